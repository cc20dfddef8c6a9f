// Requests as the daemon takes them: read and checked by the worlds, kept as their normalised text.
//
// Thread safety: as `read` is.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/request/direction_request.h"
#include "common/rpc/service.h"
#include "service/daemon/job_store.h"
#include "service/daemon/request_cost.h"

namespace sleight::daemon {

/// request::read_request with the worlds that the programs have.
using ReadRequest =
    std::function<base::Result<request::DirectionRequest, std::vector<request::Diagnostic>>(
        const std::string& text, const std::string& name)>;

/// Checks what a client sends. `ask.name` stands for a file's name in the errors; empty: "request".
base::Result<StoredRequest, rpc::Refusal> checked_request(const rpc::JobAsk& ask,
                                                          const ReadRequest& read,
                                                          const RequestLimits& limits);

/// The next revision: the same request with a longer [stop].
base::Result<StoredRequest, rpc::Refusal> extended_request(const StoredRequest& stored,
                                                           const rpc::Extension& extension,
                                                           const ReadRequest& read,
                                                           const RequestLimits& limits);

/// For a submission's idempotency: equal for equal asks. `request` is the ask's, normalised.
std::string content_of(const rpc::JobAsk& ask, const std::string& request);

}  // namespace sleight::daemon
