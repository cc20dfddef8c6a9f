// The interface through which simulations (simulation.h) use engines (engine.h). The interface
// hides an engine's broad phase and event queue.
//
// The product has one engine; tests compare it with others (tests/engines). Thread safety: none.
#pragma once

#include <memory>
#include <optional>

#include "worker/physics/event/tick.h"
#include "worker/physics/scene/scene.h"
#include "worker/physics/simulator/engine_options.h"

namespace sleight::physics {

class Replaying;
class World;

/// State that one engine passes to another. Everything up to and at `now` has happened.
struct Takeover {
  Tick now{};
  Counts counts{};
  std::optional<SceneError> failure{};
};

class AnyEngine {
 public:
  virtual ~AnyEngine() = default;

  /// Processes all events up to and at `end`. Returns nothing on success; after an error the engine
  /// keeps its state.
  virtual std::optional<SceneError> run_until(Tick end) = 0;
  virtual Tick now() const = 0;
  virtual const Counts& counts() const = 0;
  /// Returns the state for an engine that takes over.
  virtual Takeover state() const = 0;
};

/// Creates an engine that borrows the world and the replay. If `from` isn't set, the engine begins
/// before all events, and no body has started.
using EngineMaker = std::unique_ptr<AnyEngine> (*)(World& world, Replaying& replaying,
                                                   EngineOptions options,
                                                   const std::optional<Takeover>& from);

}  // namespace sleight::physics
