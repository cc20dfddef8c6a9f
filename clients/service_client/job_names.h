// Parses names of jobs: a job `17`, an inclusive range `3..8`, or a group `g5`. Pure; thread-safe.
#pragma once

#include <cstdint>
#include <span>
#include <string>
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

/// Maximum jobs in a range, so that a typing error doesn't request a billion jobs.
inline constexpr std::uint64_t k_range_jobs_max = 10'000;

/// Returns the names in the order given, or an error about the first invalid one.
base::Result<std::vector<JobName>, std::string> job_names_of(std::span<const std::string> texts);

/// Whether a single job is named, so that JSON is an object instead of a list.
bool is_single_job(std::span<const JobName> names);

/// Returns, for example, "17", "3..8" or "g5".
std::string to_string(const JobName& name);

}  // namespace sleight::service_client
