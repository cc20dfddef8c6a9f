// A rigid-body simulation, event by event.
//
//   Scene scene;
//   scene.gravity_mps2 = {0, 0, -9.81};
//   scene.contacts = ContactTable(1, {.restitution = 0.8, .friction = 0.3});
//   scene.planes.push_back({.name = "floor", .outside = {.normal = {0, 0, 1}, .offset_m = 0}});
//   scene.bodies.push_back({.name = "ball",
//                           .shape = Sphere{.radius_m = 0.02},
//                           .inertia = solid_ball_inertia(0.1, 0.02),
//                           .start = {.pose = {.position_m = {0, 0, 1}}, .twist = {}}});
//   auto started = Simulation::start(scene, {});
//   if (!started) return report(started.error().message);
//   Simulation simulation = std::move(started).value();
//   auto error = simulation.run_until(Tick{} + ticks_after(5.0));
//   if (error) return report(error->message);
//   Pose pose = simulation.pose({0}, simulation.now());
//   for (const auto& [segment, cause] : simulation.recording().segments({0})) ...
//
// Idea. Between two events a body's motion is a closed function of time (segment.h). The simulator
// predicts events, processes the least (event.h says in which order), and begins new segments for
// the bodies that it concerns. Nothing is stepped.
//
// Invariants
//   1. The recording is a function of the scene alone: algorithm and engine change how long it
//      takes, and not a bit of it.
//   2. A collision is the first tick at which a pair touches (gap <= k_touch_m) and approaches
//      (rate < -k_approach_mps); tolerances.h has the sizes.
//   3. A scene whose ticks are all shifted gives the same recording, shifted.
// Thread safety: simulations are independent; one is used by one thread.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "common/base/result.h"
#include "worker/physics/contact/surface_touches.h"
#include "worker/physics/reuse/history.h"
#include "worker/physics/reuse/recording.h"
#include "worker/physics/scene/scene.h"
#include "worker/physics/simulator/any_engine.h"
#include "worker/physics/simulator/engine_options.h"

namespace sleight::physics {

struct SimulationOptions {
  Algorithm algorithm = Algorithm::asynchronous;
  EngineMaker make_engine = nullptr;   ///< null: the product's
  bool record = true;                  ///< keep the segments; the last of each body is always kept
  std::size_t segments_reserved = 16;  ///< per body, before the recording allocates
  bool keep_history = false;  ///< keep what history() gives, from which recording() is made
  /// Of memory for that. If it takes more there will be no history, and a recording only if that is
  /// wanted.
  std::size_t history_bytes_max = std::size_t{1} << 30U;
  TickCount sample_every = 0;  ///< sampling events from tick 0 on; 0: none
  std::function<void(Tick)> on_sample{};
};

class Simulation {
 public:
  /// Checks the scene, copies it, and puts the bodies that start at tick 0 in their places. Shapes
  /// and meshes are shared with the scene, not copied.
  ///
  /// `history` is that of an earlier simulation. With it only the differences are simulated:
  /// bodies with other shapes, masses, materials or starts; bodies that come near static geometry
  /// that differs; and bodies that one of these touches or asks about for a decision about rest.
  /// The rest is replayed. All results below but counts() are the same, bit for bit, as without it.
  /// A history with other laws (gravity, surfaces, slow contacts, periods) or another number of
  /// bodies is of no use, nor is null. Compounds are the same if they are the same object. A body
  /// that takes no part starts at k_tick_max. REQUIRES: a body with the same start as in the
  /// history has the same start_again; the history's meshes and polyhedra have not been changed
  /// since.
  static base::Result<Simulation, SceneError> start(
      const Scene& scene, const SimulationOptions& options,
      std::shared_ptr<const History> history = nullptr);
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;
  ~Simulation();

  /// Processes all events up to and at `end`, and makes it the present; does nothing if that is
  /// earlier than now(). Nothing if all went well.
  std::optional<SceneError> run_until(Tick end);

  /// Continues with another algorithm or engine, and other sampling events, which come at multiples
  /// of their interval. `record`, `segments_reserved`, `keep_history` and `history_bytes_max` have
  /// no effect: recording goes on as before. A simulation that has failed stays so.
  void go_on_with(const SimulationOptions& options);

  Tick now() const;
  /// REQUIRES, here and below: the scene has the body.
  bool started(BodyId body) const;
  /// REQUIRES: the body has started, and its present segment began at or before the tick, which is
  /// not beyond now().
  Pose pose(BodyId body, Tick tick) const;
  Twist twist(BodyId body, Tick tick) const;
  /// At present. REQUIRES: the body has started.
  MotionMode mode(BodyId body) const;
  /// Of all bodies that have started.
  double kinetic_energy_j() const;
  const Counts& counts() const;
  /// Collisions with the scene's surfaces up to now(), in order; also replayed ones.
  std::span<const SurfaceTouch> surface_touches() const;
  /// Up to now(). Empty if not recorded. Of one that keeps its history it is made, or completed,
  /// here.
  const Recording& recording() const;
  /// All that happened up to now(), for replays by other simulations. Null without `keep_history`,
  /// if it takes too much memory, or after an error. Up to the first difference its chunks are
  /// shared with the history that this simulation replays.
  std::shared_ptr<const History> history() const;

 private:
  class Impl;
  explicit Simulation(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Why the scene can't be simulated; nothing if it can. Starts that overlap are found later, by
/// Simulation::start and run_until.
std::optional<SceneError> error_of(const Scene& scene);

}  // namespace sleight::physics
