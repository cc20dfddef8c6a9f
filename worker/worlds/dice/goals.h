// Goals for the dice. This file computes how far a throw is from its goals, and the resulting p_c.
//
// The goals measure a distance d >= 0:
//
//   `place`: distance of the die's centre from (x, y), in m.
//   `region`: distance of the die's centre from a rectangle, in m; 0 inside.
//   `face`, `yaw`: angle between a face's outward normal and a direction, in rad.
//   `turn`: angle of the rotation between the die's orientation and a given orientation, in rad.
//   `velocity`: difference between the centre's velocity and a given velocity, in m/s.
//   `before`: time by which the die came to rest after a given time, in s; 0 if it rested before.
//
// Each goal has a standard deviation sigma and a tolerance. A goal adds -d^2 / (2 sigma^2) to log
// p_c, so p_c is at most 1. A goal is met if d <= tolerance.
//
// Numbering (numbering.h). With Numbering::fixed, each die keeps its first numbering. With
// Numbering::free, a throw consists of unnumbered cubes. Each cube represents 24 dice that are
// equally likely before the throw. So the constraint averages over the unknown numbering: p_c(x) =
// 1/24 sum over numberings s of p_c(x, s).
//
// At beta = 1, p_c(x) is the exact marginal. p_c(x) is at most 1, so p_w p_c^beta is a path to the
// target. The program shows the numbering with the greatest p_c(x, s). If several p_c(x, s) are
// equal, it shows the least numbering. The goals are met if that numbering meets them. Tolerances
// of faces are below 45 degrees, so two faces never meet one goal. So if any numbering meets the
// goals, the shown numbering meets them too. If a rotation leaves the faces of all goals in place,
// it gives another numbering that meets the goals; numberings_that_meet counts these numberings.
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
  friend bool operator==(const Place&, const Place&) = default;
};
struct Region {
  Vec2 low_m{0, 0};
  Vec2 high_m{0, 0};
  friend bool operator==(const Region&, const Region&) = default;
};
struct FaceDirection {
  std::uint32_t face = 6;
  Vec3 direction{0, 0, 1};  ///< of length 1, in the world's frame
  friend bool operator==(const FaceDirection&, const FaceDirection&) = default;
};
struct Turn {
  Quat orientation = Quat::Identity();  ///< of the numbered die
  friend bool operator==(const Turn&, const Turn&) = default;
};
struct Velocity {
  Vec3 velocity_mps{0, 0, 0};
  friend bool operator==(const Velocity&, const Velocity&) = default;
};
struct RestBefore {
  double time_s = 0;
  friend bool operator==(const RestBefore&, const RestBefore&) = default;
};

struct Goal {
  std::uint32_t die = 0;            ///< from 0
  std::optional<double> at_s = {};  ///< time of the goal; empty: at the end, at rest
  std::variant<Place, Region, FaceDirection, Turn, Velocity, RestBefore> wanted;
  double sigma = 1;      ///< in the unit of the goal's distance, above
  double tolerance = 0;  ///< same unit as sigma
  /// Whether the goal depends on the numbering.
  bool is_of_faces() const {
    return std::holds_alternative<FaceDirection>(wanted) || std::holds_alternative<Turn>(wanted);
  }
  friend bool operator==(const Goal&, const Goal&) = default;
};

/// If a tolerance were greater, two faces could meet one goal.
inline constexpr double k_face_tolerance_max_deg = 44;

/// An unnumbered die at a point in time.
struct DieView {
  Vec3 position_m{0, 0, 0};
  Quat orientation = Quat::Identity();
  Vec3 velocity_mps{0, 0, 0};
};

/// Goals judge these views: the dice at the end, the times at which dice came to rest, and the dice
/// at the times of goal_times().
struct Views {
  std::vector<DieView> at_end;
  std::vector<double> rest_s;     ///< time at which the die came to rest; the end if it didn't
  std::vector<DieView> at_times;  ///< all dice at the first time, then all dice at the next, ...
};

struct Judgement {
  double log_constraint = 0;
  bool all_met = true;
  std::vector<std::uint32_t> numberings{};  ///< by die; 0 if numberings are fixed
  std::vector<double> distances{};          ///< by goal, for the numberings above
};

/// If it is certain that no throw of dice with these sides meets both goals, returns the reason as
/// text. Otherwise the text is empty. Goals that would put dice on top of each other at the end are
/// refused too, because stacks aren't supported.
std::string contradiction_of(const Goal& a, const Goal& b, double side_m);

/// Returns the times of all goals in ascending order. Omits duplicates.
std::vector<double> goal_times(std::span<const Goal> goals);

/// Returns the distance of one goal for a given numbering. `times` are goal_times.
double distance_of(const Goal& goal, const Views& views, std::span<const double> times,
                   std::uint32_t numbering);

/// A goal's signed distance along an axis.
struct Miss {
  double by = 0;
  double sigma = 1;  ///< the goal's sigma, in the unit of `by`
};

/// Returns two misses for a place, two for a region (from the region's middle), three for a
/// velocity, and none for other goals. `times` are goal_times.
std::vector<Miss> signed_misses(std::span<const Goal> goals, const Views& views,
                                std::span<const double> times);

/// Returns log p_c, whether all goals are met, and the shown numberings. `times` are goal_times.
Judgement judge(std::span<const Goal> goals, Numbering numbering, const Views& views,
                std::span<const double> times);

/// Returns how many of a die's 24 numberings meet its goals, if at least one numbering meets them.
/// REQUIRES: all of the die's face goals have the same time.
std::uint32_t numberings_that_meet(std::span<const Goal> goals, std::uint32_t die);

/// name_of() returns "place", "face", "yaw", ...; unit_of() returns "m", "rad", "mps" or "s".
std::string name_of(const Goal& goal);
std::string unit_of(const Goal& goal);

}  // namespace sleight::worlds::dice
