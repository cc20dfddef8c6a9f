#include "service/backend/backend.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <utility>

#include "common/base/check.h"

namespace sleight::backend {
namespace {

constexpr std::string_view k_name_begin = "sleight:";
constexpr std::size_t k_daemon_chars_min = 8;
constexpr std::size_t k_daemon_chars_max = 32;

constexpr std::array<std::pair<State, std::string_view>, 5> k_states{{{State::absent, "absent"},
                                                                      {State::waiting, "waiting"},
                                                                      {State::running, "running"},
                                                                      {State::gone, "gone"},
                                                                      {State::unknown, "unknown"}}};
constexpr std::array<std::pair<Cause, std::string_view>, 3> k_causes{
    {{Cause::itself, "itself"}, {Cause::taken, "taken"}, {Cause::cancelled, "cancelled"}}};

template <class T, std::size_t n>
std::string_view name_among(const std::array<std::pair<T, std::string_view>, n>& names, T value) {
  for (const auto& [known, name] : names)
    if (known == value) return name;
  base::check_failed("the value has a name", "");
}

template <class T, std::size_t n>
std::optional<T> value_among(const std::array<std::pair<T, std::string_view>, n>& names,
                             std::string_view name) {
  for (const auto& [value, known] : names)
    if (known == name) return value;
  return std::nullopt;
}

/// Parses a number, at least 1, that is written exactly as fmt would write it.
std::optional<std::uint64_t> number_of(std::string_view text) {
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || text.front() == '0')
    return std::nullopt;
  return number;
}

bool has_control(std::string_view text) {
  return std::ranges::any_of(text, [](char c) { return static_cast<unsigned char>(c) < 0x20; });
}

[[noreturn]] void refuse(const std::string& words) {
  throw base::Error(base::ExitCode::usage, words);
}

}  // namespace

bool is_daemon_name(std::string_view text) {
  return text.size() >= k_daemon_chars_min && text.size() <= k_daemon_chars_max &&
         std::ranges::all_of(
             text, [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); });
}

std::string to_text(const AttemptName& name) {
  CHECK(is_daemon_name(name.daemon));
  return fmt::format("{}{}:{}:{}", k_name_begin, name.daemon, name.job, name.epoch);
}

std::optional<AttemptName> attempt_name_of(std::string_view text) {
  if (!text.starts_with(k_name_begin)) return std::nullopt;
  text.remove_prefix(k_name_begin.size());
  const std::size_t first = text.find(':');
  const std::size_t second = first == text.npos ? text.npos : text.find(':', first + 1);
  if (second == text.npos) return std::nullopt;
  const std::string_view daemon = text.substr(0, first);
  const std::string_view job_text = text.substr(first + 1, second - first - 1);
  const std::string_view epoch_text = text.substr(second + 1);
  if (!is_daemon_name(daemon) || job_text.empty() || epoch_text.empty()) return std::nullopt;
  const auto job = number_of(job_text);
  const auto epoch = number_of(epoch_text);
  if (!job || !epoch) return std::nullopt;
  return AttemptName{.daemon = std::string(daemon), .job = *job, .epoch = *epoch};
}

std::string_view name_of(State state) {
  return name_among(k_states, state);
}
std::optional<State> state_of(std::string_view name) {
  return value_among(k_states, name);
}
std::string_view name_of(Cause cause) {
  return name_among(k_causes, cause);
}
std::optional<Cause> cause_of(std::string_view name) {
  return value_among(k_causes, name);
}

void check_order(const Order& order) {
  if (!is_daemon_name(order.name.daemon) || order.name.job == 0 || order.name.epoch == 0)
    refuse(
        "the attempt needs a daemon name (8 to 32 characters of a-z and 0-9), a job and an epoch");
  if (!order.folder.starts_with('/') || has_control(order.folder))
    refuse(fmt::format("the folder must be an absolute path without control characters, found '{}'",
                       order.folder));
  if (order.command.empty() || !order.command.front().starts_with('/'))
    refuse("the command must begin with an absolute path");
  if (has_control(order.label)) refuse("the label contains control characters");
  for (const auto& [key, value] : order.options)
    if (has_control(key) || has_control(value))
      refuse(fmt::format("the option '{}' contains control characters", key));
}

std::string end_of_file(const std::string& path, std::size_t bytes_max) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) return {};
  const auto size = static_cast<std::size_t>(std::max<std::streamoff>(0, file.tellg()));
  const std::size_t begin = size - std::min(size, bytes_max);
  std::string text(size - begin, '\0');
  file.seekg(static_cast<std::streamoff>(begin));
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, file.gcount())));
  const std::size_t line = text.find('\n');
  if (begin > 0 && line != std::string::npos && line + 1 < text.size()) text.erase(0, line + 1);
  return text;
}

}  // namespace sleight::backend
