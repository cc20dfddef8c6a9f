// The jobs that people named, as the service has them.
//
// Of a range, numbers without a job (deleted, or another user's) are left out; where none is left,
// that is an error. Any other name must be there. No job comes twice.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "clients/service_client/job_names.h"
#include "common/rpc/client.h"

namespace sleight::service_client {

/// Throws base::Error(usage) for what names no job.
std::vector<JobName> read_job_names(std::span<const std::string> texts);

/// Their views, in the order of the names, without histories unless asked for.
std::vector<rpc::JobView> views_of(rpc::Client& client, std::span<const JobName> names,
                                   bool with_history = false);

/// All jobs of a group, oldest first. Throws RefusedError where there is no such group.
std::vector<rpc::JobView> jobs_of(rpc::Client& client, rpc::GroupId group);

/// Of several names, one for which the call was refused.
struct RefusedName {
  std::string name{};  ///< "17", "g5"
  rpc::Refusal refusal{};
};

struct TouchedJobs {
  std::vector<rpc::Touched> done{};
  std::vector<RefusedName> refused{};
};

/// Changes each name as `ask` says, a group at once, and gathers what became of each job. One that
/// is refused keeps no other from its change; alone it is thrown as a RefusedError.
TouchedJobs change(rpc::Client& client, std::span<const JobName> names, rpc::ChangeAsk ask);

}  // namespace sleight::service_client
