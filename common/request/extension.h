// Extends a run beyond its original request, by the same request with a longer [stop].
//
// All else stays, including a sampler that the world chose, because for other rules of [stop] the
// world might choose another one. The run continues with the same chains. The run's archive equals
// that of the longer request run from scratch. Thread safety: values and pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/base/result.h"
#include "common/request/direction_request.h"

namespace sleight::request {

/// Rules of [stop] for the longer run, at least one. The first that holds ends the run.
struct Extension {
  std::optional<std::uint64_t> scans{};
  std::optional<std::uint32_t> rounds{};
  /// Independent solutions, and as many finds if [stop] has `found`; for a search only finds.
  std::optional<std::uint32_t> solutions{};
  std::optional<double> odds{};  ///< standard error of log P, in nats
  friend bool operator==(const Extension&, const Extension&) = default;
};

/// The reason why an extension is refused, as a sentence.
struct NotLonger {
  std::string why;
};

/// Returns the normalised text of the longer request, for read_request, which checks the values.
/// The extension's rules replace those of [stop], except `found` for a search before chains.
/// Refuses an empty extension, or one that requests no more than [stop] did.
base::Result<std::string, NotLonger> extended_text(const DirectionRequest& request,
                                                   const Extension& extension);

}  // namespace sleight::request
