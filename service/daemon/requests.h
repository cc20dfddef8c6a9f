// Checks requests by means of the worlds, and normalises their text. Thread safety: that of `read`.
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

/// request::read_request with the installed worlds.
using ReadRequest =
    std::function<base::Result<request::DirectionRequest, std::vector<request::Diagnostic>>(
        const std::string& text, const std::string& name)>;

/// Checks a client's request. `ask.name` is the file name in errors. Default: "request".
base::Result<StoredRequest, rpc::Refusal> checked_request(const rpc::JobAsk& ask,
                                                          const ReadRequest& read,
                                                          const RequestLimits& limits);

/// Returns the next revision: the same request with a longer [stop].
base::Result<StoredRequest, rpc::Refusal> extended_request(const StoredRequest& stored,
                                                           const rpc::Extension& extension,
                                                           const ReadRequest& read,
                                                           const RequestLimits& limits);

/// Returns a digest of the ask and its normalised request. Equal asks have equal digests.
std::string content_of(const rpc::JobAsk& ask, const std::string& request);

}  // namespace sleight::daemon
