// The daemon's side of a backend: carries out the machine's effects on attempts, and reports what
// is seen of them. There are two implementations. local_attempts.h is for this machine and notices
// a keeper's end at once. system_attempts.h is for batch systems, which it queries periodically.
//
//   `Launch` writes request.toml and starts a keeper. Once the keeper has its record: Launched.
//   `Look` leads to a Sight, now or soon.
//   `Stop` sends a signal to the keeper.
//
// Thread safety: all on the loop's thread. launch, stop and look never call `hear` directly.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "service/jobs/messages.h"

namespace sleight::daemon {

/// The data of a job that a launch needs besides its id.
struct LaunchText {
  std::string request{};
  bool strict = false;
  /// The job's options for the batch system (backend::Options). Ignored on this machine.
  std::map<std::string, std::string> options{};
};

class Attempts {
 public:
  using Hear = std::function<void(jobs::Input)>;
  using TextOf = std::function<LaunchText(jobs::JobId, std::uint64_t revision)>;

  virtual ~Attempts() = default;

  virtual void launch(const jobs::Launch& launch) = 0;
  virtual void stop(const jobs::Stop& stop) = 0;
  virtual void look(const jobs::Look& look) = 0;

  /// A note on programs replaced since the last look (AttemptSights::look_at_programs).
  virtual std::optional<jobs::BackendNote> look_at_programs() = 0;

  /// Number of attempts that are being awaited.
  virtual std::size_t running() const = 0;
};

}  // namespace sleight::daemon
