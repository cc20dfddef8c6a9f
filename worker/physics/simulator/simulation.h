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
// Idea. Between two events, a body's motion is a closed function of time (segment.h). The simulator
// predicts events and processes the earliest one (event.h defines the order). The event's bodies
// then begin new segments. There are no time steps.
//
// Invariants
//   1. The recording depends only on the scene. Algorithm and engine affect only the computing
//      time.
//   2. A pair collides at the first tick at which it touches (gap <= k_touch_m) and approaches
//      (rate < -k_approach_mps); see tolerances.h.
//   3. If all ticks of a scene are shifted, the recording's ticks are shifted equally, and nothing
//      else changes.
// Thread safety: simulations are independent; each is used by one thread at a time.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "common/base/result.h"
#include "worker/physics/contact/impacts.h"
#include "worker/physics/contact/surface_touches.h"
#include "worker/physics/reuse/history.h"
#include "worker/physics/reuse/recording.h"
#include "worker/physics/scene/scene.h"
#include "worker/physics/simulator/any_engine.h"
#include "worker/physics/simulator/engine_options.h"

namespace sleight::physics {

struct SimulationOptions {
  Algorithm algorithm = Algorithm::asynchronous;
  EngineMaker make_engine = nullptr;  ///< null: the product's
  bool record = true;  ///< store the segments; the last one per body is always stored
  std::size_t segments_reserved = 16;  ///< per body, before the recording allocates
  bool keep_history = false;  ///< store the data for history(), from which recording() is derived
  /// Memory limit for the history. If the history exceeds the limit, history() returns null. If
  /// `record` is set, a recording is still made.
  std::size_t history_bytes_max = std::size_t{1} << 30U;
  bool keep_impacts = false;   ///< list the collisions for impacts()
  TickCount sample_every = 0;  ///< sampling events from tick 0 on; 0: none
  std::function<void(Tick)> on_sample{};
};

class Simulation {
 public:
  /// Checks the scene, copies it, and places the bodies that start at tick 0. Shapes and meshes are
  /// shared with the scene, not copied.
  ///
  /// `history` comes from an earlier simulation. With a history, a body is simulated only if it
  /// differs in shape, mass, material, group or start, or comes near changed static geometry. If a
  /// simulated body touches another body, or examines it in a rest decision, that body is simulated
  /// too, unless it is fixed. All other bodies are replayed. All results except counts() are the
  /// same, bit for bit, as without a history.
  ///
  /// The history is ignored if its scene has other laws (gravity, surfaces, slow contacts, periods,
  /// filter, speed and deviations of contact noise) or another number of bodies. Two compounds are
  /// equal only if they are one object. To remove a body, let it start at k_tick_max. REQUIRES: if
  /// a body starts as in the history, its start_again is the same too; the history's meshes and
  /// polyhedra are unchanged.
  static base::Result<Simulation, SceneError> start(
      const Scene& scene, const SimulationOptions& options,
      std::shared_ptr<const History> history = nullptr);
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;
  ~Simulation();

  /// Processes all events up to and at `end`, which becomes now(). Does nothing if `end` is earlier
  /// than now(). Returns nothing on success.
  std::optional<SceneError> run_until(Tick end);

  /// Continues with another algorithm, engine and sampling interval. Sampling events happen at
  /// multiples of the interval. `record`, `segments_reserved`, `keep_history`, `history_bytes_max`
  /// and `keep_impacts` have no effect: recording continues as before. A failed simulation stays
  /// failed.
  void go_on_with(const SimulationOptions& options);

  Tick now() const;
  /// Here and below, REQUIRES: the scene has the body.
  bool started(BodyId body) const;
  /// REQUIRES: the body has started; the tick is in its current segment and not beyond now().
  Pose pose(BodyId body, Tick tick) const;
  Twist twist(BodyId body, Tick tick) const;
  /// Current mode. REQUIRES: the body has started.
  MotionMode mode(BodyId body) const;
  /// Kinetic energy of all bodies that have started.
  double kinetic_energy_j() const;
  const Counts& counts() const;
  /// Collisions with the scene's surfaces up to now(), in order. Includes replayed collisions.
  std::span<const SurfaceTouch> surface_touches() const;
  /// All collisions up to now(), in order, replayed ones too. Empty if `keep_impacts` is off.
  std::span<const Impact> impacts() const;
  /// Recording up to now(); empty if not recorded. If the simulation stores a history, this call
  /// creates or completes the recording.
  const Recording& recording() const;
  /// The history up to now(), for replays by other simulations. Null if `keep_history` is off, if
  /// the history exceeded the memory limit, or after an error. Shares chunks with the replayed
  /// history, up to the first difference.
  std::shared_ptr<const History> history() const;

 private:
  class Impl;
  explicit Simulation(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Returns why the scene can't be simulated, or nothing if it can. Doesn't detect overlapping
/// starts: Simulation::start and run_until do.
std::optional<SceneError> error_of(const Scene& scene);

}  // namespace sleight::physics
