// A run that shall go on beyond what it was asked for: the same request with a longer [stop].
//
// All else stays, the sampler included: a request that left it open has one by now, and for other
// rules of [stop] the world might choose another. The run goes on with the same chains, and its
// archive is that of the longer request run at once.
//
// Thread safety: values and pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/base/result.h"
#include "common/request/direction_request.h"

namespace sleight::request {

/// Rules of [stop], of which the first that holds ends the longer run; at least one.
struct Extension {
  std::optional<std::uint64_t> scans{};
  std::optional<std::uint32_t> rounds{};
  /// Independent ones, and as many finds where [stop] asks for finds; of a search finds.
  std::optional<std::uint32_t> solutions{};
  std::optional<double> odds{};  ///< standard error of log P, in nats
  friend bool operator==(const Extension&, const Extension&) = default;
};

/// Why an extension is none, as a sentence.
struct NotLonger {
  std::string why;
};

/// The normalised text of the longer request, to be read again: read_request then judges the
/// values. The extension's rules take the place of [stop]'s, but for `found` beside chains, which
/// is the search before them. Refused where the extension is empty, or asks for no more than [stop]
/// did.
base::Result<std::string, NotLonger> extended_text(const DirectionRequest& request,
                                                   const Extension& extension);

}  // namespace sleight::request
