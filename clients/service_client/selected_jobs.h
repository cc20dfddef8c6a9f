// Gets the named jobs from the service. In a range, numbers without a visible job (deleted, or
// another user's) are skipped, but at least one job must exist. Every other name must exist. No job
// occurs twice.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "clients/service_client/job_names.h"
#include "common/rpc/client.h"

namespace sleight::service_client {

/// Throws base::Error(usage) for an invalid name.
std::vector<JobName> read_job_names(std::span<const std::string> texts);

/// Returns the jobs in the order of the names.
std::vector<rpc::JobView> views_of(rpc::Client& client, std::span<const JobName> names,
                                   bool with_history = false);

/// Returns all jobs of a group, oldest first. Throws RefusedError if there is no such group.
std::vector<rpc::JobView> jobs_of(rpc::Client& client, rpc::GroupId group);

/// A refused name among several.
struct RefusedName {
  std::string name{};  ///< such as "17" or "g5"
  rpc::Refusal refusal{};
};

struct TouchedJobs {
  std::vector<rpc::Touched> done{};
  std::vector<RefusedName> refused{};
};

/// Applies `ask` to each named job, or to a group as a whole, and collects the results. A refused
/// name doesn't prevent other changes. If there is only one name, its refusal is thrown as a
/// RefusedError.
TouchedJobs change(rpc::Client& client, std::span<const JobName> names, rpc::ChangeAsk ask);

}  // namespace sleight::service_client
