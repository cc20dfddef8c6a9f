// Extends a run beyond its original request. The new request is the same but has a longer [stop]. A
// sampler that the world chose is also kept, because for other rules the world might choose
// another. The run continues with the same chains. The run's archive then equals the archive of the
// longer request, run from scratch. Thread safety: values and pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/base/result.h"
#include "common/request/direction_request.h"

namespace sleight::request {

/// Rules of [stop] for the longer run, at least one. The first rule that holds ends the run.
struct Extension {
  std::optional<std::uint64_t> scans{};
  std::optional<std::uint32_t> rounds{};
  /// Number of independent solutions. If [stop] has `found`, also the number of finds. For a
  /// search, only the number of finds.
  std::optional<std::uint32_t> solutions{};
  std::optional<double> odds{};  ///< standard error of log P, in nats
  friend bool operator==(const Extension&, const Extension&) = default;
};

/// The reason why an extension is refused, as a sentence.
struct NotLonger {
  std::string why;
};

/// Returns the normalised text of the longer request. The caller passes it to read_request, which
/// checks the values. The extension's rules replace the rules of [stop], but `found` stays if the
/// search precedes chains. Refuses an extension that is empty or requests no more than [stop] did.
base::Result<std::string, NotLonger> extended_text(const DirectionRequest& request,
                                                   const Extension& extension);

}  // namespace sleight::request
