// Checks a user's scene: what it contains, what is wrong with it, and what happens in it without
// uncertainty. The result becomes tables of facts, and text for people.
//
// The tables are in SI units; `sleight scene check --json` prints them unchanged. A column's key
// ends in its unit, from which the text makes the column's head and format. The text begins with
// what needs attention. Thread safety: pure functions and values.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "worker/physics/reuse/recording.h"
#include "worker/worlds/user_scene/end_watch.h"
#include "worker/worlds/user_scene/user_scene.h"

namespace sleight::worlds::user_scene {

// ---- overlaps -----------------------------------------------------------------------------------

struct Overlap {
  std::uint32_t a = 0;  ///< index of a moving body in BuiltScene::objects
  std::uint32_t b = 0;  ///< index of another object; above `a`
  double depth_m = 0;   ///< 0: they touch
  /// The centre of mass of `a` is inside the solid `b`. The true depth is at least depth_m.
  bool inside = false;
};

/// Returns all objects that overlap or touch at their start, in ascending order of (a, b).
/// REQUIRES: error_of(scene) has none.
///
/// The simulator refuses such a scene, and names only the first pair (SceneError::overlap). A pair
/// overlaps if the gap is at most k_touch_m, or if a body's centre of mass is inside a static
/// solid. A body that starts at rest may touch what carries it: static objects and other bodies at
/// rest, within k_at_rest_gap_m. Moving bodies are compared with each other only if they start at
/// the same tick. Pairs that the collision filter separates are skipped.
///
/// The depth is the length of the shortest shift that separates two convex pieces. If bodies have
/// several pieces, it is the greatest depth of a pair of pieces. A triangle of a mesh is a piece of
/// zero thickness. Where a round piece overlaps deeply, a search over directions finds the depth.
/// It may stop at a greater depth than the least.
std::vector<Overlap> overlaps_of(const BuiltScene& built);

// ---- a simulation without uncertainty -----------------------------------------------------------

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

/// The run ends at SceneDescription::end_s, or earlier: when every body rests or has left the
/// scene, when it has too many events, or when the simulator fails.
NominalRun nominal_run(const SceneDescription& description, const BuiltScene& built,
                       std::uint64_t events_max = k_run_events_max);

// ---- draws from the prior -----------------------------------------------------------------------

struct PriorDraws {
  std::uint64_t count = 0;
  std::uint64_t overlap = 0;      ///< impossible starts (End)
  std::uint64_t failed = 0;       ///< simulations
  std::uint64_t not_settled = 0;  ///< a body still moved at end_s
  std::uint64_t met = 0;          ///< all constraints
  /// Least, mean and greatest of each value (Quantities::values).
  std::vector<std::array<double, 3>> values{};
  /// By constraint: how often it was met, and the least distance.
  std::vector<std::uint64_t> constraint_met{};
  std::vector<double> least_distances{};  ///< infinite without a simulation
};

/// Simulates the draws 0, 1, ... (sampling::nth_prior_draw), at most `count_max`. After each draw
/// the loop ends if `go_on` returns false.
PriorDraws prior_draws(const UserScene& world, std::uint64_t count_max,
                       const std::function<bool(std::uint64_t done)>& go_on);

// ---- the report ---------------------------------------------------------------------------------

/// Whether a mesh, helix or ramp encloses a solid. The triangles of a closed mesh are anticlockwise
/// seen from outside. If they are clockwise, everything outside the mesh is solid.
struct Closedness {
  std::uint32_t object = 0;          ///< index in BuiltScene::objects
  std::uint64_t boundary_edges = 0;  ///< 0: the mesh is closed
  double volume_m3 = 0;              ///< enclosed; negative: inside out; 0: the mesh is open
};

struct SceneReport {
  const SceneDescription& description;
  const BuiltScene& built;
  std::vector<Closedness> meshes{};
  std::vector<Overlap> overlaps{};
  /// None if objects overlap: the simulator would refuse the scene.
  std::optional<NominalRun> run{};
  std::optional<PriorDraws> draws{};  ///< none if nothing is uncertain
  const UserScene* world = nullptr;   ///< of the draws
  /// Each is a sentence with the names of objects. The worst come first.
  std::vector<std::string> warnings{};
};

/// REQUIRES: `built` was made from `description`; both outlive the report.
SceneReport check(const SceneDescription& description, const BuiltScene& built);

/// Adds prior draws to the report of the same scene. REQUIRES: `world` outlives the report.
void add_draws(const UserScene& world, PriorDraws draws, SceneReport& report);

/// Returns words such as "time is over".
const char* name_of(RunEnd end);

using Cell =
    std::variant<std::nullptr_t, bool, std::uint64_t, double, std::string, std::vector<double>>;

struct Table {
  std::string title;                 ///< in the text; empty: only JSON has the table
  std::string key;                   ///< in JSON
  bool of_run;                       ///< in JSON, part of "run"
  std::vector<std::string> columns;  ///< keys
  std::vector<std::vector<Cell>> rows{};
};

std::vector<Table> tables_of(const SceneReport& report);

std::string report_text(const SceneReport& report);

}  // namespace sleight::worlds::user_scene
