#include "clients/service_client/job_names.h"

#include <fmt/format.h>

#include <charconv>
#include <optional>

#include "common/request/text.h"

namespace sleight::service_client {
namespace {

/// Parses an id, which is at least 1.
std::optional<std::uint64_t> number_of(std::string_view text) {
  std::uint64_t number = 0;
  const char* end = text.data() + text.size();
  const auto [rest, failure] = std::from_chars(text.data(), end, number);
  if (failure != std::errc() || rest != end || number == 0) return std::nullopt;
  return number;
}

std::optional<JobName> job_name_of(std::string_view text) {
  if (text.starts_with('g')) {
    const auto group = number_of(text.substr(1));
    return group ? std::optional<JobName>(rpc::GroupId{*group}) : std::nullopt;
  }
  const std::size_t dots = text.find("..");
  if (dots == std::string_view::npos) {
    const auto job = number_of(text);
    return job ? std::optional<JobName>(rpc::JobId{*job}) : std::nullopt;
  }
  const auto first = number_of(text.substr(0, dots));
  const auto last = number_of(text.substr(dots + 2));
  if (!first || !last || *first > *last) return std::nullopt;
  return JobRange{.first = *first, .last = *last};
}

}  // namespace

base::Result<std::vector<JobName>, std::string> job_names_of(std::span<const std::string> texts) {
  constexpr std::size_t k_shown_characters_max = 40;
  std::vector<JobName> names;
  for (const std::string& text : texts) {
    const auto name = job_name_of(text);
    if (!name) {
      return fmt::format(
          "'{}' is not a job; expected a job number (17), a range (3..8) or a group (g5)",
          request::printable(text, k_shown_characters_max));
    }
    if (const auto* range = std::get_if<JobRange>(&*name)) {
      if (range->last - range->first >= k_range_jobs_max)
        return fmt::format("{} names more than {} jobs", to_string(*name), k_range_jobs_max);
    }
    names.push_back(*name);
  }
  return names;
}

bool is_single_job(std::span<const JobName> names) {
  return names.size() == 1 && std::holds_alternative<rpc::JobId>(names.front());
}

std::string to_string(const JobName& name) {
  if (const auto* job = std::get_if<rpc::JobId>(&name)) return fmt::format("{}", *job);
  if (const auto* group = std::get_if<rpc::GroupId>(&name)) return fmt::format("g{}", *group);
  const auto& range = std::get<JobRange>(name);
  return fmt::format("{}..{}", range.first, range.last);
}

}  // namespace sleight::service_client
