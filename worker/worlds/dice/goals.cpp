#include "worker/worlds/dice/goals.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "common/base/check.h"
#include "common/math/elementary.h"
#include "worker/sampling/log_sum.h"

namespace sleight::worlds::dice {
namespace {

template <class... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <class... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;

double angle_between(const Vec3& a, const Vec3& b) {
  return math::atan2(math::norm(math::cross(a, b)), math::dot(a, b));
}

/// A face's outward normal in the world's frame.
Vec3 normal_of(const Quat& orientation, std::uint32_t face, std::uint32_t numbering) {
  // The normal is a column of the matrix or the column's negative, so the bits are equal for all
  // numberings that put the face there.
  const AxisDirection direction = direction_of_face(face, numbering);
  const math::Mat3 axes = math::matrix_of(orientation);
  const double sign = direction.sign;
  return {sign * axes(0, direction.axis), sign * axes(1, direction.axis),
          sign * axes(2, direction.axis)};
}

double angle_between(const Quat& a, const Quat& b) {
  const Quat between = math::composed(a, math::inverse(b));
  const Vec3 v(between.x(), between.y(), between.z());
  return 2 * math::atan2(math::norm(v), std::fabs(between.w()));
}

double outside(double x, double low, double high) {
  return std::max({0.0, low - x, x - high});
}

double log_density(double distance, double sigma) {
  const double z = distance / sigma;
  return -0.5 * z * z;
}

/// The region in which a goal requires the die's centre. Empty if the goal requires no region.
std::optional<Region> area_of(const Goal& goal) {
  if (const auto* region = std::get_if<Region>(&goal.wanted)) return *region;
  if (const auto* place = std::get_if<Place>(&goal.wanted))
    return Region{.low_m = place->centre_m, .high_m = place->centre_m};
  return std::nullopt;
}

/// Distances between two regions: between their nearest points, and between their farthest points.
struct Apart {
  double least_m = 0;
  double most_m = 0;
};
Apart apart(const Region& a, const Region& b) {
  const Vec2 beyond = a.low_m - b.high_m;
  const Vec2 before = b.low_m - a.high_m;
  const Vec2 least = beyond.cwiseMax(before).cwiseMax(Vec2(0, 0));
  const Vec2 most = (a.high_m - b.low_m).cwiseMax(b.high_m - a.low_m);
  return {.least_m = math::norm(least), .most_m = math::norm(most)};
}

/// Returns a lower bound on the sum of the angles by which an orientation misses two goals. If the
/// goals aren't both about orientations, returns nothing.
std::optional<double> turn_difference(const Goal& a, const Goal& b) {
  const auto* turn = std::get_if<Turn>(&a.wanted);
  const auto* face = std::get_if<FaceDirection>(&b.wanted);
  if (turn == nullptr && std::holds_alternative<Turn>(b.wanted)) return turn_difference(b, a);
  if (turn != nullptr && face != nullptr)
    return angle_between(normal_of(turn->orientation, face->face, 0), face->direction);
  if (turn != nullptr && std::holds_alternative<Turn>(b.wanted))
    return angle_between(turn->orientation, std::get<Turn>(b.wanted).orientation);
  const auto* other = std::get_if<FaceDirection>(&a.wanted);
  if (face == nullptr || other == nullptr) return std::nullopt;
  const Quat still = Quat::Identity();
  return std::fabs(
      angle_between(normal_of(still, face->face, 0), normal_of(still, other->face, 0)) -
      angle_between(face->direction, other->direction));
}

}  // namespace

std::string contradiction_of(const Goal& a, const Goal& b, double side_m) {
  if (a.at_s != b.at_s) return {};
  // Goals that agree up to rounding don't contradict each other.
  const double slack = (a.tolerance + b.tolerance) * (1 + 1e-9) + 1e-12;
  const auto area_a = area_of(a);
  const auto area_b = area_of(b);
  if (a.die != b.die) {
    // In flight, one die may be above the other.
    if (!area_a || !area_b || a.at_s) return {};
    const double most_m = apart(*area_a, *area_b).most_m + slack;
    if (most_m >= side_m / 2) return {};
    return fmt::format(
        "dice {} and {} would have to lie on top of each other, which is not supported: their "
        "centres would be at most {:.3g} mm apart, but a die is {:.3g} mm wide",
        std::min(a.die, b.die) + 1, std::max(a.die, b.die) + 1, 1e3 * most_m, 1e3 * side_m);
  }
  if (area_a && area_b) {
    const double least_m = apart(*area_a, *area_b).least_m;
    if (least_m <= slack) return {};
    return fmt::format(
        "die {} can't meet both goals: their places are {:.3g} mm apart, but the tolerances add up "
        "to {:.3g} mm",
        a.die + 1, 1e3 * least_m, 1e3 * slack);
  }
  if (const auto differ_rad = turn_difference(a, b); differ_rad && *differ_rad > slack) {
    constexpr double k_deg_per_rad = 57.295779513082321;
    return fmt::format(
        "die {} can't meet both goals: their orientations differ by {:.3g} degrees, but the "
        "tolerances add up to {:.3g} degrees",
        a.die + 1, k_deg_per_rad * *differ_rad, k_deg_per_rad * slack);
  }
  const auto* velocity_a = std::get_if<Velocity>(&a.wanted);
  const auto* velocity_b = std::get_if<Velocity>(&b.wanted);
  if (velocity_a == nullptr || velocity_b == nullptr) return {};
  const double apart_mps = math::norm(Vec3(velocity_a->velocity_mps - velocity_b->velocity_mps));
  if (apart_mps <= slack) return {};
  return fmt::format(
      "die {} can't meet both goals: their velocities differ by {:.3g} m/s, but the tolerances add "
      "up to {:.3g} m/s",
      a.die + 1, apart_mps, slack);
}

std::vector<double> goal_times(std::span<const Goal> goals) {
  std::vector<double> times;
  for (const Goal& goal : goals) {
    if (goal.at_s) times.push_back(*goal.at_s);
  }
  std::ranges::sort(times);
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

namespace {

const DieView& die_of(const Goal& goal, const Views& views, std::span<const double> times) {
  const std::size_t dice = views.at_end.size();
  CHECK_LT(goal.die, dice);
  if (!goal.at_s) return views.at_end[goal.die];
  const auto time = std::ranges::lower_bound(times, *goal.at_s);
  CHECK(time != times.end() && *time == *goal.at_s);
  const auto nth = static_cast<std::size_t>(time - times.begin());
  return views.at_times.at(nth * dice + goal.die);
}

}  // namespace

double distance_of(const Goal& goal, const Views& views, std::span<const double> times,
                   std::uint32_t numbering) {
  const DieView* die = &die_of(goal, views, times);
  return std::visit(
      Overloaded{
          [&](const Place& place) {
            const Vec3& p = die->position_m;
            return math::norm(Vec2(p.x() - place.centre_m.x(), p.y() - place.centre_m.y()));
          },
          [&](const Region& region) {
            const Vec3& p = die->position_m;
            return math::norm(Vec2(outside(p.x(), region.low_m.x(), region.high_m.x()),
                                   outside(p.y(), region.low_m.y(), region.high_m.y())));
          },
          [&](const FaceDirection& face) {
            return angle_between(normal_of(die->orientation, face.face, numbering), face.direction);
          },
          [&](const Turn& turn) {
            return angle_between(math::composed(die->orientation, rotation_of_numbering(numbering)),
                                 turn.orientation);
          },
          [&](const Velocity& velocity) {
            return math::norm(Vec3(die->velocity_mps - velocity.velocity_mps));
          },
          [&](const RestBefore& before) {
            return std::max(0.0, views.rest_s[goal.die] - before.time_s);
          }},
      goal.wanted);
}

std::vector<Miss> signed_misses(std::span<const Goal> goals, const Views& views,
                                std::span<const double> times) {
  std::vector<Miss> misses;
  for (const Goal& goal : goals) {
    const DieView& die = die_of(goal, views, times);
    if (const auto* place = std::get_if<Place>(&goal.wanted)) {
      for (const Eigen::Index axis : {0, 1})
        misses.push_back({die.position_m[axis] - place->centre_m[axis], goal.sigma});
    } else if (const auto* region = std::get_if<Region>(&goal.wanted)) {
      for (const Eigen::Index axis : {0, 1}) {
        const double half = 0.5 * (region->high_m[axis] - region->low_m[axis]);
        misses.push_back(
            {die.position_m[axis] - (region->low_m[axis] + half), goal.sigma + 0.5 * half});
      }
    } else if (const auto* velocity = std::get_if<Velocity>(&goal.wanted)) {
      for (const Eigen::Index axis : {0, 1, 2})
        misses.push_back({die.velocity_mps[axis] - velocity->velocity_mps[axis], goal.sigma});
    }
  }
  return misses;
}

Judgement judge(std::span<const Goal> goals, Numbering numbering, const Views& views,
                std::span<const double> times) {
  const std::size_t dice = views.at_end.size();
  Judgement judgement{.numberings = std::vector<std::uint32_t>(dice, 0)};

  // Evaluate goals of faces: choose each die's shown numbering, and average over all numberings.
  for (std::uint32_t die = 0; numbering == Numbering::free && die < dice; ++die) {
    std::array<double, k_numberings> logs{};
    bool has_faces = false;
    for (const Goal& goal : goals) {
      if (goal.die != die || !goal.is_of_faces()) continue;
      has_faces = true;
      for (std::uint32_t s = 0; s < k_numberings; ++s)
        logs[s] += log_density(distance_of(goal, views, times, s), goal.sigma);
    }
    if (!has_faces) continue;
    const auto most = std::ranges::max_element(logs);  // the first of equals
    judgement.numberings[die] = static_cast<std::uint32_t>(most - logs.begin());
    sampling::LogSum sum;
    for (const double log : logs)
      sum.add(log);
    judgement.log_constraint += sum.log_mean();
  }

  // Evaluate the other goals, and compute all distances.
  for (const Goal& goal : goals) {
    const double distance = distance_of(goal, views, times, judgement.numberings.at(goal.die));
    judgement.distances.push_back(distance);
    judgement.all_met = judgement.all_met && distance <= goal.tolerance;
    if (numbering == Numbering::fixed || !goal.is_of_faces())
      judgement.log_constraint += log_density(distance, goal.sigma);
  }
  return judgement;
}

std::uint32_t numberings_that_meet(std::span<const Goal> goals, std::uint32_t die) {
  std::uint32_t count = 0;
  for (std::uint32_t s = 0; s < k_numberings; ++s) {
    const bool keeps_all = std::ranges::all_of(goals, [&](const Goal& goal) {
      if (goal.die != die || !goal.is_of_faces()) return true;
      const auto* face = std::get_if<FaceDirection>(&goal.wanted);
      return face == nullptr ? s == 0
                             : direction_of_face(face->face, s) == direction_of_face(face->face, 0);
    });
    count += keeps_all ? 1 : 0;
  }
  return count;
}

std::string name_of(const Goal& goal) {
  return std::visit(Overloaded{[](const Place&) -> std::string { return "place"; },
                               [](const Region&) -> std::string { return "region"; },
                               [](const FaceDirection& face) -> std::string {
                                 return face.direction.z() == 1 ? "face" : "yaw";
                               },
                               [](const Turn&) -> std::string { return "orientation"; },
                               [](const Velocity&) -> std::string { return "velocity"; },
                               [](const RestBefore&) -> std::string { return "before"; }},
                    goal.wanted);
}

std::string unit_of(const Goal& goal) {
  if (goal.is_of_faces()) return "rad";
  if (std::holds_alternative<Velocity>(goal.wanted)) return "mps";
  return std::holds_alternative<RestBefore>(goal.wanted) ? "s" : "m";
}

}  // namespace sleight::worlds::dice
