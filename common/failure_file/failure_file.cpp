#include "common/failure_file/failure_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "common/request/document.h"
#include "common/request/text.h"

namespace sleight::failure_file {
namespace {

constexpr std::string_view k_digits = "0123456789abcdef";
constexpr std::string_view k_section = "failure";
constexpr std::string_view k_request_begin = "\n[world]";
constexpr std::string_view k_checksum_begin = "checksum = ";

std::string hexadecimal(base::BytesView bytes) {
  std::string text;
  text.reserve(2 * bytes.size());
  for (const std::byte byte : bytes) {
    text += k_digits[static_cast<std::size_t>(byte >> 4U)];
    text += k_digits[static_cast<std::size_t>(byte & std::byte{15})];
  }
  return text;
}

std::optional<base::Bytes> bytes_of_hexadecimal(std::string_view text) {
  if (text.size() % 2 != 0) return std::nullopt;
  base::Bytes bytes;
  bytes.reserve(text.size() / 2);
  for (std::size_t i = 0; i < text.size(); i += 2) {
    const std::size_t high = k_digits.find(text[i]);
    const std::size_t low = k_digits.find(text[i + 1]);
    if (high == std::string_view::npos || low == std::string_view::npos) return std::nullopt;
    bytes.push_back(static_cast<std::byte>(16 * high + low));
  }
  return bytes;
}

/// Returns FNV-1a (Fowler, Noll, Vo) of two concatenated texts, as 16 hexadecimal digits.
std::string checksum_of(std::string_view first, std::string_view second) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const std::string_view text : {first, second}) {
    for (const char c : text) {
      hash ^= static_cast<unsigned char>(c);
      hash *= 0x100000001b3U;
    }
  }
  return fmt::format("{:016x}", hash);
}

class Keys {
 public:
  Keys(const request::Section& section, std::string path)
      : section_(section), path_(std::move(path)) {}

  std::string text(std::string_view key) {
    const request::Value* value = find(key);
    if (value == nullptr) return {};
    if (const auto* text = std::get_if<std::string>(&value->held)) return *text;
    complain(value->place, fmt::format("'{}' must be a string", key));
    return {};
  }
  std::uint64_t number(std::string_view key, std::uint64_t max) {
    const request::Value* value = find(key);
    if (value == nullptr) return 0;
    const auto* number = std::get_if<std::int64_t>(&value->held);
    if (number != nullptr && *number >= 0 && static_cast<std::uint64_t>(*number) <= max)
      return static_cast<std::uint64_t>(*number);
    complain(value->place, fmt::format("'{}' must be an integer from 0 to {}", key, max));
    return 0;
  }
  /// Returns parse(text). If the result is empty, records an error.
  template <class Parse>
  auto parsed(std::string_view key, const Parse& parse, std::string_view expected) {
    auto value = parse(text(key));
    if (!value && !complaint_)
      complain(section_.find(key)->value.place, fmt::format("'{}' must be {}", key, expected));
    return value;
  }
  const std::optional<request::Diagnostic>& complaint() const { return complaint_; }

 private:
  const request::Value* find(std::string_view key) {
    const request::Entry* entry = section_.find(key);
    if (entry != nullptr) return &entry->value;
    complain(section_.place, fmt::format("[{}] has no key '{}'", k_section, key));
    return nullptr;
  }
  void complain(request::Place place, std::string what) {
    if (!complaint_)
      complaint_ = request::Diagnostic{.file = path_, .place = place, .message = std::move(what)};
  }

  const request::Section& section_;
  std::string path_;
  std::optional<request::Diagnostic> complaint_;
};

/// Returns an error if the file's checksum is wrong. Returns nothing if the checksum is right or
/// absent.
std::optional<request::Diagnostic> damage_of(const request::Section& section, std::string_view text,
                                             const std::string& path) {
  const request::Entry* entry = section.find("checksum");
  if (entry == nullptr) return std::nullopt;
  const std::size_t line = text.find(fmt::format("\n{}", k_checksum_begin));
  if (line != std::string_view::npos) {
    const std::string_view before = text.substr(0, line + 1);
    const std::size_t end = text.find('\n', line + 1);
    const std::string_view after = text.substr(std::min(end, text.size() - 1) + 1);
    const auto* stored = std::get_if<std::string>(&entry->value.held);
    if (stored != nullptr && *stored == checksum_of(before, after)) return std::nullopt;
  }
  return request::Diagnostic{.file = path,
                             .place = entry->value.place,
                             .message =
                                 "the file has changed since it was written; to replay the changed "
                                 "file, remove the line 'checksum'"};
}

}  // namespace

std::string to_text(const FailureFile& file) {
  const plan::SimulationFailure& failure = file.failed.failure;
  const std::string head = fmt::format(
      "# A simulation that failed. `sleight replay FILE` repeats the simulation.\n"
      "[{}]\nprogram_version = {}\nkind = {}\nmessage = {}\nchain = {}\nreplica = {}\nscan = {}\n"
      "state = {}\n",
      k_section, request::toml_string(file.program_version),
      request::toml_string(plan::name_of(failure.kind)), request::toml_string(failure.message),
      file.replica.chain.value, file.replica.replica.value, file.failed.scan.value,
      request::toml_string(hexadecimal(failure.state)));
  return fmt::format("{}{}\"{}\"\n{}", head, k_checksum_begin, checksum_of(head, file.request_text),
                     file.request_text);
}

base::Result<FailureFile, request::Diagnostic> read(std::string_view text,
                                                    const std::string& path) {
  // Split the text where the request begins.
  const std::size_t begin = std::min(text.find(k_request_begin), text.size());
  const std::string_view head = text.substr(0, begin);
  const std::string_view rest = text.substr(begin);
  auto parsed = request::parse_document(head, path);
  if (!parsed) return parsed.error();
  const request::Section* section = parsed.value().find(k_section);
  if (section == nullptr || rest.empty()) {
    return request::Diagnostic{
        .file = path,
        .place = {.line = 1, .column = 1},
        .message = fmt::format("not a failure file: the section [{}] is missing",
                               section == nullptr ? k_section : "world")};
  }

  Keys keys(*section, path);
  const auto kind = keys.parsed(
      "kind", [](const std::string& name) { return plan::failure_kind_of(name); },
      fmt::format("one of {}", fmt::join(plan::k_failure_names, ", ")));
  auto state = keys.parsed("state", bytes_of_hexadecimal, "hexadecimal");
  constexpr std::uint64_t k_u32_max = std::numeric_limits<std::uint32_t>::max();
  constexpr std::uint64_t k_scan_max = std::numeric_limits<std::int64_t>::max();
  FailureFile file{
      .program_version = keys.text("program_version"),
      .request_text = std::string(static_cast<std::size_t>(std::ranges::count(head, '\n')), '\n') +
                      std::string(rest),
      .replica = {base::ChainId{static_cast<std::uint32_t>(keys.number("chain", k_u32_max))},
                  base::ReplicaId{static_cast<std::uint32_t>(keys.number("replica", k_u32_max))}},
      .failed = {.scan = base::ScanIndex{keys.number("scan", k_scan_max)},
                 .failure = {.kind = kind.value_or(plan::FailureKind{}),
                             .message = keys.text("message"),
                             .state = std::move(state).value_or(base::Bytes{})}}};
  if (keys.complaint()) return *keys.complaint();
  if (auto damage = damage_of(*section, text, path)) return *damage;
  return file;
}

std::string name_of(const plan::ReplicaKey& replica, base::ScanIndex scan, std::size_t nth) {
  const std::string again = nth == 0 ? "" : fmt::format("-{}", nth);
  return fmt::format("failure-{}-{}-{}{}.toml", replica.chain.value, replica.replica.value,
                     scan.value, again);
}

}  // namespace sleight::failure_file
