// How dice must end: goals, how far from them a throw is, and what p_c makes of that.
//
// Each goal has a distance d >= 0 of what came of the throw, a standard deviation and a tolerance:
//
//   place      of the centre from (x, y)                                      m
//   region     of the centre from a rectangle, 0 inside                       m
//   direction  angle between a face's outward normal and a direction: the     rad
//              vertical ("face up"), or a horizontal one ("yaw")
//   turn       angle of the rotation between the die's orientation and one    rad
//   velocity   of the centre's velocity from one                              m/s
//   before     how long after a time the die came to rest, 0 if before it     s
//
// Each adds -d^2 / (2 sigma^2) to log p_c, so p_c is at most 1; it is met if d <= tolerance.
//
// Numbering (numbering.h). With Numbering::fixed dice are numbered as they are. With
// Numbering::free a throw is that of unnumbered cubes, each of which stands for 24 dice, equally
// likely before the throw; the constraint is that of a die whose numbering is not known,
//
//   p_c(x) = 1/24 sum over numberings s of p_c(x, s),
//
// the exact marginal at beta = 1, and bounded by 1, so that p_w p_c^beta is a path to it. The
// numbering with the greatest p_c(x, s) is shown, the least of equals; the goals are met if that
// numbering meets them. If any numbering meets them, this one does: tolerances of faces are below
// 45 degrees, so two faces never meet one goal. Rotations that leave all goals' faces in place give
// further numberings that meet them; numberings_that_meet counts those.
//
// Thread safety: values and pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "common/math/rotation.h"
#include "common/math/vector.h"
#include "worker/worlds/dice/numbering.h"

namespace sleight::worlds::dice {

using math::Vec2;

enum class Numbering : std::uint8_t { free, fixed };

struct Place {
  Vec2 centre_m{0, 0};
};
struct Region {
  Vec2 low_m{0, 0};
  Vec2 high_m{0, 0};
};
struct FaceDirection {
  std::uint32_t face = 6;
  Vec3 direction{0, 0, 1};  ///< of length 1, in the world's frame
};
struct Turn {
  Quat orientation = Quat::Identity();  ///< of the numbered die
};
struct Velocity {
  Vec3 velocity_mps{0, 0, 0};
};
struct RestBefore {
  double time_s = 0;
};

struct Goal {
  std::uint32_t die = 0;            ///< from 0
  std::optional<double> at_s = {};  ///< when it is looked at; none: at the end, at rest
  std::variant<Place, Region, FaceDirection, Turn, Velocity, RestBefore> wanted;
  double sigma = 1;      ///< in the unit of its distance, above
  double tolerance = 0;  ///< likewise
  /// Whether it hangs on which face is which.
  bool is_of_faces() const {
    return std::holds_alternative<FaceDirection>(wanted) || std::holds_alternative<Turn>(wanted);
  }
};

/// More would let two faces meet one goal.
inline constexpr double k_face_tolerance_max_deg = 44;

/// A die, unnumbered, at some time.
struct DieView {
  Vec3 position_m{0, 0, 0};
  Quat orientation = Quat::Identity();
  Vec3 velocity_mps{0, 0, 0};
};

/// What goals look at: the dice at the end, when they came to rest, and the dice at the times of
/// goal_times, time by time.
struct Views {
  std::vector<DieView> at_end;
  std::vector<double> rest_s;     ///< the end, if the die is not at rest
  std::vector<DieView> at_times;  ///< the dice in order, for one time after another
};

struct Judgement {
  double log_constraint = 0;
  bool all_met = true;
  std::vector<std::uint32_t> numberings{};  ///< by die: 0 where they are fixed
  std::vector<double> distances{};          ///< by goal, with these numberings
};

/// Why no throw of dice with these sides meets both, for people; empty where only a throw can tell.
/// Dice that would have to lie on one another at the end are refused too: stacks are not directed.
std::string contradiction_of(const Goal& a, const Goal& b, double side_m);

/// The times at which goals look, ascending, each once.
std::vector<double> goal_times(std::span<const Goal> goals);

/// The distance of one goal with a numbering. `times` are goal_times.
double distance_of(const Goal& goal, const Views& views, std::span<const double> times,
                   std::uint32_t numbering);

/// By how much a goal is missed in one direction, with a sign.
struct Miss {
  double by = 0;
  double sigma = 1;  ///< how far off is as good as not: the goal's, in the same unit
};

/// Of goals that say where to or how fast: two for a place or a region (from its middle), three for
/// a velocity. The others have none. `times` are goal_times.
std::vector<Miss> signed_misses(std::span<const Goal> goals, const Views& views,
                                std::span<const double> times);

/// log p_c, whether all goals are met, and the numbering that is shown. `times` are goal_times.
Judgement judge(std::span<const Goal> goals, Numbering numbering, const Views& views,
                std::span<const double> times);

/// Of the 24 numberings of a die, how many meet its goals if one does. REQUIRES: its goals of faces
/// look at one time.
std::uint32_t numberings_that_meet(std::span<const Goal> goals, std::uint32_t die);

/// "place", "face", "yaw", ... and its unit, "m" or "rad": for names.
std::string name_of(const Goal& goal);
std::string unit_of(const Goal& goal);

}  // namespace sleight::worlds::dice
