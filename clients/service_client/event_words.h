// Describes a job's events to people, in one line each. Pure; thread-safe.
#pragma once

#include <string>

#include "common/events/run_event.h"
#include "common/rpc/service.h"

namespace sleight::service_client {

/// Returns, for example, "solution 3 (in the model's proportions): chain 2, scan 400, log p -12.3"
/// for the third such solution. A line of progress has no job name.
std::string words_of_event(rpc::JobId job, const events::RunEvent& event);

/// Returns the job's state, the number of the start unless this is the first start, and the reason.
std::string words_of_change(const rpc::StateChange& change);

}  // namespace sleight::service_client
