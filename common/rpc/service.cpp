#include "common/rpc/service.h"

#include <algorithm>
#include <array>

namespace sleight::rpc {
namespace {

constexpr std::array<std::string_view, k_refusal_kinds> k_refusal_names = {
    "unknown", "not_found", "not_allowed", "bad_request", "conflict",
    "limit",   "busy",      "gone",        "environment", "bug"};
constexpr std::array<std::string_view, k_job_states> k_state_names = {
    "unknown", "queued", "starting", "running", "yielding", "held", "done", "failed", "cancelled"};
constexpr std::array<std::string_view, k_change_kinds> k_change_names = {
    "unknown", "cancel", "hold", "resume", "extend", "erase", "pin", "unpin", "set_priority"};

}  // namespace

std::string_view name_of(RefusalKind kind) {
  return k_refusal_names.at(static_cast<std::size_t>(kind));
}

std::string_view name_of(JobState state) {
  return k_state_names.at(static_cast<std::size_t>(state));
}

std::string_view name_of(ChangeKind kind) {
  return k_change_names.at(static_cast<std::size_t>(kind));
}

bool is_file_name(std::string_view name) {
  return !name.empty() && name.front() != '.' && name.size() <= k_name_bytes_max &&
         std::none_of(name.begin(), name.end(),
                      [](char c) { return c == '/' || static_cast<unsigned char>(c) < 0x20; });
}

std::optional<JobState> job_state_of(std::string_view name) {
  for (std::size_t state = 1; state < k_job_states; ++state) {
    if (k_state_names[state] == name) return static_cast<JobState>(state);
  }
  return std::nullopt;
}

std::string_view name_of(Scope scope) {
  switch (scope) {
    case Scope::read:
      return "read";
    case Scope::submit:
      return "submit";
    case Scope::manage:
      return "manage";
    case Scope::operate:
      return "operate";
    case Scope::unknown:
      break;
  }
  return "unknown";
}

std::optional<Scope> scope_of(std::string_view name) {
  for (const Scope scope : k_scopes)
    if (name_of(scope) == name) return scope;
  return std::nullopt;
}

}  // namespace sleight::rpc
