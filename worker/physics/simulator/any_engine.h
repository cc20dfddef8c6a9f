// An engine (engine.h) behind a simulation (simulation.h), whatever its broad phase and queue.
//
// The product has one. Tests compare it with others (tests/engines).
// Thread safety: none.
#pragma once

#include <memory>
#include <optional>

#include "worker/physics/event/tick.h"
#include "worker/physics/scene/scene.h"
#include "worker/physics/simulator/engine_options.h"

namespace sleight::physics {

class Replaying;
class World;

/// Where another engine stopped: everything up to and at `now` has happened.
struct Takeover {
  Tick now{};
  Counts counts{};
  std::optional<SceneError> failure{};
};

class AnyEngine {
 public:
  virtual ~AnyEngine() = default;

  /// Processes every event up to and at `end`. Nothing if all went well; after an error the engine
  /// stays where it is.
  virtual std::optional<SceneError> run_until(Tick end) = 0;
  virtual Tick now() const = 0;
  virtual const Counts& counts() const = 0;
  /// What another one takes over.
  virtual Takeover state() const = 0;
};

/// Makes an engine that borrows the world and what is replayed in it. It begins before everything
/// in one without bodies, or takes over.
using EngineMaker = std::unique_ptr<AnyEngine> (*)(World& world, Replaying& replaying,
                                                   EngineOptions options,
                                                   const std::optional<Takeover>& from);

}  // namespace sleight::physics
