// How people name jobs: `17`, a range `3..8` with both ends, a group `g5`; commands take several.
//
// Pure; thread-safe.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "common/base/result.h"
#include "common/rpc/service.h"

namespace sleight::service_client {

struct JobRange {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  bool operator==(const JobRange&) const = default;
};

using JobName = std::variant<rpc::JobId, JobRange, rpc::GroupId>;

/// Of one range: a slip of the keyboard must not ask for each of a billion jobs.
inline constexpr std::uint64_t k_range_jobs_max = 10'000;

/// The names in the order given, or a sentence about the first that is none.
base::Result<std::vector<JobName>, std::string> job_names_of(std::span<const std::string> texts);

/// Whether a single job is named, so that JSON is one object, not a list.
bool is_single_job(std::span<const JobName> names);

/// "17", "3..8", "g5".
std::string to_string(const JobName& name);

}  // namespace sleight::service_client
