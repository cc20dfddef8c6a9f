// The daemon's side of a backend: carries out the machine's effects on attempts, and reports the
// attempts' states. There are two implementations. local_attempts.h runs attempts on this machine
// and notices a keeper's end at once. system_attempts.h runs them in a batch system and queries the
// system periodically.
//
//   `Launch` writes request.toml and starts a keeper, whose record leads to Launched.
//   `Look` asks for the attempt's state, which is reported as a Sight.
//   `Stop` sends a signal to the keeper.
//
// Thread safety: only the loop's thread makes calls. launch(), stop() and look() never call `hear`
// directly.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "service/jobs/messages.h"

namespace sleight::daemon {

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

  /// Returns AttemptSights::look_at_programs().
  virtual std::optional<jobs::BackendNote> look_at_programs() = 0;

  /// Returns the number of attempts whose end is awaited.
  virtual std::size_t running() const = 0;
};

}  // namespace sleight::daemon
