// Simulates a scene once, without uncertainty, and tells what each body did.
//
// The simulation ends at SceneDescription::end_s, or earlier: when every body rests or has left the
// scene, when it has too many events, or when the simulator fails. Thread safety: a pure function.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "worker/physics/reuse/recording.h"
#include "worker/worlds/user_scene/end_watch.h"

namespace sleight::worlds::user_scene {

enum class RunEnd : std::uint8_t {
  all_ended,   ///< every body rests or has left
  time_over,   ///< some bodies still move at end_s
  work_limit,  ///< too many events
  error        ///< NominalRun::error
};

/// What a moving body did. Place and speed are those at the run's end.
struct BodyOutcome {
  BodyEnd end = BodyEnd::waits;
  double rests_since_s = 0;  ///< if it rests
  Pose place{};              ///< of the shape's frame in the world
  double speed_mps = 0;      ///< of the centre of mass
  std::uint64_t hits = 0;    ///< collisions with other objects
};

/// The collisions of two objects.
struct Hits {
  std::uint32_t a = 0;
  std::uint32_t b = 0;  ///< above `a`
  std::uint64_t count = 0;
  double first_s = 0;
};

struct NominalRun {
  RunEnd end = RunEnd::all_ended;
  double end_s = 0;
  std::vector<BodyOutcome> bodies{};  ///< by moving body; empty if the simulation can't start
  std::vector<Hits> hits{};           ///< ascending first_s
  std::optional<physics::SceneError> error{};
  std::shared_ptr<const physics::Recording> recording{};  ///< null if the simulation can't start
};

/// Maximum collisions and changes of lasting contacts in a run.
inline constexpr std::uint64_t k_run_events_max = 300'000;

NominalRun nominal_run(const SceneDescription& description, const BuiltScene& built,
                       std::uint64_t events_max = k_run_events_max);

}  // namespace sleight::worlds::user_scene
