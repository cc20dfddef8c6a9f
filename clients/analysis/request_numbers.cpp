#include "clients/analysis/request_numbers.h"

#include <fmt/format.h>

#include <utility>

#include "common/base/error.h"

namespace sleight::analysis {
namespace {

request::Document parsed(std::string_view text, std::string_view archive) {
  auto document = request::parse_document(text, archive);
  if (!document) {
    throw base::Error(base::ExitCode::bad_archive,
                      "can't read its request: " + request::to_string(document.error()));
  }
  return std::move(document).value();
}

}  // namespace

RequestNumbers::RequestNumbers(std::string_view request_text, std::string_view archive)
    : document_(parsed(request_text, archive)), archive_(archive) {}

std::optional<double> RequestNumbers::find(std::string_view section, std::string_view key) const {
  const request::Section* found = document_.find(section);
  const request::Entry* entry = found == nullptr ? nullptr : found->find(key);
  if (entry == nullptr) return std::nullopt;
  if (const auto* number = std::get_if<double>(&entry->value.held)) return *number;
  if (const auto* integer = std::get_if<std::int64_t>(&entry->value.held)) {
    return static_cast<double>(*integer);
  }
  return std::nullopt;
}

double RequestNumbers::at(std::string_view section, std::string_view key) const {
  if (const std::optional<double> number = find(section, key)) return *number;
  throw base::Error(
      base::ExitCode::bad_archive,
      fmt::format("{}: the request has no number '{}' in [{}]", archive_, key, section));
}

std::string scan_label(const RequestNumbers& numbers) {
  return numbers.find("sampler", "iterations_per_scan") == 1.0 ? "iteration" : "scan";
}

}  // namespace sleight::analysis
