// Carries out what the machine of jobs says of attempts, and tells it what is seen of them: the
// daemon's side of a backend. There are two: local_attempts.h for this machine, which hears of a
// keeper's end at once, and system_attempts.h for batch systems, which are asked now and then.
//
//   Launch ──▶ request.toml and the backend; once the keeper has its record: Launched
//   Look   ──▶ Sight, now or soon
//   Stop   ──▶ a signal to the keeper
//
// Thread safety: all on the loop's thread. What is heard is told through `hear`, never from inside
// launch, stop or look.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "service/jobs/messages.h"

namespace sleight::daemon {

/// What a launch needs of the job beside its number.
struct LaunchText {
  std::string request{};
  bool strict = false;
  /// What the job wishes of the batch system (backend::Options); of no meaning on this machine.
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

  /// Of programs that were replaced since the last look, the first one included: what the machine
  /// is to hear of them.
  virtual std::optional<jobs::BackendNote> look_at_programs() = 0;

  /// Attempts that are waited for.
  virtual std::size_t running() const = 0;
};

}  // namespace sleight::daemon
