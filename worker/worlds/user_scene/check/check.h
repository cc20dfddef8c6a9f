// Checks a user's scene: what it contains, what is wrong with it, and what happens in it without
// uncertainty. The result becomes tables of facts, and text for people.
//
// The tables are in SI units; `sleight scene check --json` prints them unchanged. A column's key
// ends in its unit, from which the text makes the column's head and format. The text begins with
// what needs attention. Thread safety: pure functions and values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "worker/worlds/user_scene/build.h"
#include "worker/worlds/user_scene/check/nominal_run.h"
#include "worker/worlds/user_scene/check/overlaps.h"
#include "worker/worlds/user_scene/check/prior_draws.h"

namespace sleight::worlds::user_scene {

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
