// What happens to a job, in one line for people.
//
// Pure; thread-safe.
#pragma once

#include <string>

#include "common/events/run_event.h"
#include "common/rpc/service.h"

namespace sleight::service_client {

/// "in proportion 3: chain 2, scan 400, log p -12.3". Of progress its line without a name.
std::string words_of_event(rpc::JobId job, const events::RunEvent& event);

/// "running, start 2: goes on from scan 400".
std::string words_of_change(const rpc::StateChange& change);

}  // namespace sleight::service_client
