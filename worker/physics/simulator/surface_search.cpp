#include "worker/physics/simulator/surface_search.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "worker/physics/simulator/first_collision.h"
#include "worker/physics/simulator/surface_points.h"

namespace sleight::physics {
namespace {

using namespace surface_points;

/// Parallelograms may miss closing by this part of their size.
constexpr double k_parallel = 1e-9;
/// A part that is clear for this share of the time that others allow needn't be split; but when
/// that is short, it is, as the collision is near.
constexpr double k_long_enough = 0.7;
constexpr double k_long_s = 3e-4;
/// How much further a second bound of when a point collides reaches than the first one says.
constexpr double k_a_bit_more = 1.1;
/// After a shorter span than this the points that are near are found again.
constexpr double k_worth_s = 1e-4;
/// Points are near that may touch within so many times the span of a look, as that is now.
constexpr double k_looks_ahead = 3;
constexpr double k_ahead_s_max = 2e-3;
/// They are at least those that are as close, and none if that would be a large part of a box.
constexpr double k_near_m_min = 5e-6;
constexpr double k_near_share = 0.1;
/// Bounds hold while the box's centre stays within this part of its reach; when it is higher than
/// anything near, within a whole one and a patch.
constexpr double k_room = 0.25;

/// How fast anything changes at most, while the box stays in the region that the bounds are of.
struct Pace {
  SurfaceBounds surface;
  double stretch = 1;              ///< sqrt(1 + slope^2): length of (-S_x, -S_y, 1)
  double bend_per_m = 0;           ///< of the surface, up or down
  double past_mps = 0;             ///< of any point of the box, horizontally
  double turning_radps = 0;        ///< of the box
  double fall_mps2 = 0;            ///< the second derivative of a gap is no less than minus this
  double jerk_mps3 = k_forever_s;  ///< nor does it change faster, where the box turns evenly
  double valid_s = 0;

  /// The same of one point's gap, for so long: at least 0.
  double fall_of(const Above& point, double until_s) const {
    if (jerk_mps3 == k_forever_s) return fall_mps2;
    const double fall = -point.pull_mps2 + 0.5 * jerk_mps3 * until_s;
    return std::clamp(fall, 0.0, fall_mps2);
  }
};

/// As long as any simulation: finite, as products of nothing and for ever aren't numbers.
constexpr double k_always_s = seconds(k_tick_max.value);

/// How long the centre stays within a horizontal distance.
double stays_within_s(const MovingPiece& box, double room_m) {
  const auto across = [](const Vec3& v) { return std::sqrt(v.x() * v.x() + v.y() * v.y()); };
  const double speed_mps = across(box.velocity_mps);
  const double root = std::sqrt(speed_mps * speed_mps + 2 * across(box.acceleration_mps2) * room_m);
  return 2 * room_m < k_always_s * (speed_mps + root) ? 2 * room_m / (speed_mps + root)
                                                      : k_always_s;
}

SurfaceBounds bounds_around(SplineSurface& surface, const MovingPiece& box, double room_m) {
  const Vec3& centre_m = box.pose.position_m;
  const double away_m = box.reach_m + room_m;
  return surface.bounds_in(centre_m.x() - away_m, centre_m.x() + away_m, centre_m.y() - away_m,
                           centre_m.y() + away_m);
}

Pace pace_of(SplineSurface& surface, const MovingPiece& box) {
  const double room_m = k_room * box.reach_m;
  Pace pace{.surface = bounds_around(surface, box, room_m)};
  const SurfaceBounds& bounds = pace.surface;
  const Vec3& pull_mps2 = box.acceleration_mps2;
  const double aside_mps2 =
      std::sqrt(pull_mps2.x() * pull_mps2.x() + pull_mps2.y() * pull_mps2.y());
  const double turning_mps = std::sqrt(box.turning_acceleration_mps2 * box.reach_m);
  pace.valid_s = stays_within_s(box, room_m);
  pace.stretch = std::sqrt(1 + bounds.slope * bounds.slope);
  pace.bend_per_m = std::max(bounds.hollow_per_m, bounds.bump_per_m);
  const double gained_mps = aside_mps2 > 0 ? aside_mps2 * pace.valid_s : 0;
  const Vec3& v = box.velocity_mps;
  pace.past_mps = std::sqrt(v.x() * v.x() + v.y() * v.y()) + turning_mps + gained_mps;
  pace.turning_radps = std::max(math::norm(box.angular_velocity_radps), turning_mps / box.reach_m);
  // d2/dt2 (z - S) = z'' - grad S . x'' - x'^T H x', with x'' of the centre and of turning.
  pace.fall_mps2 = std::max(0.0, (bounds.slope * aside_mps2 - pull_mps2.z()) +
                                     pace.stretch * box.turning_acceleration_mps2 +
                                     bounds.hollow_per_m * (pace.past_mps * pace.past_mps));
  if (box.turns_evenly) {
    // d3/dt3 (z - S): the point's own, (-grad S, 1) . j, and -3 v^T H a - T v^3 of the surface.
    pace.jerk_mps3 =
        pace.stretch * pace.turning_radps * box.turning_acceleration_mps2 +
        pace.past_mps * (3 * pace.bend_per_m * (aside_mps2 + box.turning_acceleration_mps2) +
                         bounds.twist_per_m2 * (pace.past_mps * pace.past_mps));
  }
  return pace;
}

class Look {
 public:
  Look(SplineSurface& surface, const BoxLattice& lattice, const MovingPiece& box, const Pace& pace)
      : points_(surface, box), surface_(surface), lattice_(lattice), box_(box), pace_(pace) {}

  /// A time before which no point collides, not beyond the one for which the pace holds; 0 if one
  /// does, which is then contact().
  double failing_s() { return lowest_corner_counts() ? best_s_ : failing_of_all_s(); }
  /// The same with the help of what earlier looks have kept, and for later ones.
  double failing_s(NearPoints& near) {
    if (near.known && see_others(near)) {
      note_all(near);
      if (others_clear_until(best_s_)) return best_s_;
      const double others_s = others_failing_s();
      if (others_s >= k_worth_s) return std::min(best_s_, others_s);
    }
    if (lowest_corner_counts()) return best_s_;
    if (gather(near) && see_others(near)) {
      note_all(near);
      if (others_clear_until(best_s_)) return best_s_;
      const double others_s = others_failing_s();
      if (others_s >= k_worth_s) return std::min(best_s_, others_s);
    }
    return failing_of_all_s();
  }
  bool collides() const { return colliding_; }
  const Above& contact() const { return contact_; }

 private:
  /// Whether the lowest corner alone counts, before the time that corners allow. Looks at these.
  bool lowest_corner_counts() {
    best_s_ = pace_.valid_s;
    corners_ = corners_of(points_);
    for (const Above& corner : corners_)
      note(corner);
    return is_above_lowest_until(corners_, lattice_.steps_most, pace_.surface.hollow_per_m,
                                 horizon_s());
  }
  double failing_of_all_s() {
    for (const EdgeLattice& edge : lattice_.edges)
      visit(Stretch{&edge, {0, edge.steps}, {corners_[edge.end[0]], corners_[edge.end[1]]}});
    for (const FaceLattice& face : lattice_.faces)
      visit(cell_of(face, corners_));
    return shortened_ ? k_long_enough * best_s_ : best_s_;
  }

  void note_all(const NearPoints& near) {
    best_s_ = pace_.valid_s;
    for (std::size_t i = 0; i < near.count; ++i)
      note(points_.above(near.own_m[i]));
  }
  /// What corners may still move before others than those near count. False if that is nothing.
  bool see_others(const NearPoints& near) {
    others_ = {.pull_mps2 = std::fabs(box_.acceleration_mps2.z()) + box_.turning_acceleration_mps2,
               .room_m = near.room_m};
    const double aside_mps = near.slope * pace_.past_mps;
    for (std::size_t i = 0; i < near.corners_m.size(); ++i) {
      const Vec3 place_m = points_.place_m(box_.view->vertices_m[i]);
      const Vec3 moved_m = place_m - near.corners_m[i];
      const double gone_m = std::fabs(moved_m.x()) + std::fabs(moved_m.y());  // or less
      others_.left_m[i] = near.allowed_m[i] - (std::fabs(moved_m.z()) + near.slope * gone_m);
      others_.rate_mps[i] = std::fabs(upwards_mps(place_m)) + aside_mps;
      others_.room_m = std::min(others_.room_m, near.room_m - gone_m);
      if (others_.left_m[i] <= 0) return false;
    }
    return others_.room_m > 0;
  }
  bool others_clear_until(double until_s) const {
    const double pull_mps = 0.5 * others_.pull_mps2 * until_s;
    for (std::size_t i = 0; i < others_.left_m.size(); ++i) {
      if (others_.left_m[i] <= (others_.rate_mps[i] + pull_mps) * until_s) return false;
    }
    return others_.room_m > pace_.past_mps * until_s;
  }
  /// How long that is so.
  double others_failing_s() const {
    double until_s = pace_.past_mps > 0 ? others_.room_m / pace_.past_mps : k_forever_s;
    for (std::size_t i = 0; i < others_.left_m.size(); ++i) {
      const double rate_mps = others_.rate_mps[i];
      const double root =
          std::sqrt(rate_mps * rate_mps + 2 * others_.pull_mps2 * others_.left_m[i]);
      if (rate_mps + root > 0)
        until_s = std::min(until_s, 2 * others_.left_m[i] / (rate_mps + root));
    }
    return until_s;
  }
  double upwards_mps(const Vec3& place_m) const {
    const Vec3 arm_m = place_m - box_.pose.position_m;
    return box_.velocity_mps.z() + math::cross(box_.angular_velocity_radps, arm_m).z();
  }
  /// Finds what is near enough to count in this look and some more like it, for a while. False if
  /// that is too much.
  bool gather(NearPoints& near) {
    near.known = false;
    const double span_s = k_looks_ahead * std::min(best_s_, k_ahead_s_max);
    const double aside_mps = pace_.surface.slope * pace_.past_mps + pace_.fall_mps2 * span_s;
    double most_m = 0;
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      near.corners_m[i] = corners_[i].place_m;
      near.allowed_m[i] = std::max(
          k_near_m_min, (std::fabs(upwards_mps(corners_[i].place_m)) + aside_mps) * span_s);
      most_m = std::max(most_m, near.allowed_m[i]);
    }
    if (most_m > k_near_share * box_.reach_m) return false;
    near.slope = pace_.surface.slope;
    near.room_m = k_room * box_.reach_m;
    near.count = 0;
    bool fits = true;
    Points points(surface_, box_, near.allowed_m);
    visit_all_low(
        points, lattice_, corners_of(points), pace_.surface.bump_per_m,
        [&] { return fits ? k_touch_m : -k_forever_s; },
        [&](const Above& point) {
          if (point.gap_m - point.allowed_m > 2 * k_touch_m || !fits) return;
          const auto kept = std::span(near.own_m).first(near.count);
          if (std::ranges::find(kept, point.own_m) != kept.end()) return;
          fits = near.count < NearPoints::k_most;
          if (fits) near.own_m[near.count++] = point.own_m;
        });
    near.known = fits;
    return fits;
  }

  /// How far ahead parts are looked at: within a tick is now, and then each point counts.
  double horizon_s() const { return std::max(best_s_, k_seconds_per_tick); }

  /// When a point may collide, if that is sooner than `until_s`, which it is else.
  double collides_after_s(const Above& point, double until_s) const {
    return std::min(
        until_s, first_collision_s(point.gap_m, point.rate_mps, pace_.fall_of(point, until_s), 0));
  }

  void note(const Above& point) {
    lowest_m_ = std::min(lowest_m_, point.gap_m);
    // The bound is concave in time: what is out of touch now and then is so in between.
    const double fall_mps = 0.5 * pace_.fall_of(point, best_s_) * best_s_;
    if (point.gap_m > k_touch_m && point.gap_m + (point.rate_mps - fall_mps) * best_s_ > k_touch_m)
      return;
    const double soon_s = collides_after_s(point, best_s_);
    // A bound for a shorter time is a better one.
    if (soon_s < best_s_)
      best_s_ = collides_after_s(point, std::min(best_s_, k_a_bit_more * soon_s));
    if (point.gap_m > k_touch_m || point.rate_mps * point.normal().z() >= -k_approach_mps) return;
    if (colliding_ && point.gap_m >= contact_.gap_m) return;
    colliding_ = true;
    contact_ = point;
  }

  /// What a point must be higher than another one, a share 1 / steps of the way to which it is away
  /// from that, to be out of touch as long as that doesn't collide.
  double needed_m(std::int32_t steps, double gap_m) const {
    return steps * (2 * k_touch_m + std::max(0.0, -std::min(gap_m, lowest_m_)));
  }
  /// Whether points on the way along `d` from one with such slopes are higher than it for so long,
  /// or so much; `d` turns, and the slopes change as that point moves on.
  bool rises_until(const Vec3& d, double slope_x, double slope_y, double hollow_per_m, double by_m,
                   double until_s) const {
    const double across2 = d.x() * d.x() + d.y() * d.y();
    const double higher_m =
        ((d.z() - slope_x * d.x()) - slope_y * d.y()) - 0.5 * hollow_per_m * across2 - by_m;
    if (higher_m <= 0) return false;
    const double length_m = std::sqrt(across2 + d.z() * d.z());
    const double loss_mps =
        length_m * (pace_.turning_radps * (pace_.stretch + hollow_per_m * length_m) +
                    pace_.bend_per_m * pace_.past_mps);
    return higher_m > loss_mps * until_s;
  }

  /// Whether all that is spanned by some points is out of touch for so long, unless the lowest of
  /// them collides. What counts is at least a share 1 / steps of the way from there to the others.
  bool is_above_lowest_until(std::span<const Above> points, std::int32_t steps, double hollow_per_m,
                             double until_s) const {
    std::size_t lowest = 0;
    for (std::size_t i = 1; i < points.size(); ++i) {
      if (points[i].gap_m < points[lowest].gap_m) lowest = i;
    }
    const Above& least = points[lowest];
    const double by_m = needed_m(steps, least.gap_m);
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (i != lowest && !rises_until(points[i].place_m - least.place_m, least.slope_x,
                                      least.slope_y, hollow_per_m, by_m, until_s))
        return false;
    }
    return true;
  }
  /// The same unless a point of the box's edges collides, where a side of the cell is one of these.
  bool is_above_edge_until(const Cell& cell, double hollow_per_m, double until_s) const {
    for (std::size_t side = 0; side < 4; ++side) {
      if (!cell.is_outer(side)) continue;
      const Above& one = cell.corners[side];
      const Above& other = cell.corners[(side + 1) % 4];
      const Vec3 across_m = cell.corners[(side + 3) % 4].place_m - one.place_m;
      // Slopes anywhere on the side, against those at the nearer end.
      const Vec3 half_m = 0.5 * (other.place_m - one.place_m);
      const double by_m = needed_m(cell.steps(), std::min(one.gap_m, other.gap_m)) +
                          pace_.bend_per_m * math::norm(half_m) * math::norm(across_m);
      if (rises_until(across_m, one.slope_x, one.slope_y, hollow_per_m, by_m, until_s) &&
          rises_until(across_m, other.slope_x, other.slope_y, hollow_per_m, by_m, until_s))
        return true;
    }
    return false;
  }
  static bool is_above_edge_until(const Stretch&, double, double) { return false; }

  /// Whether what is between the ends or corners of a part doesn't collide for so long.
  template <class Part>
  bool is_clear_until(const Part& part, const SurfaceBounds& under, double until_s) const {
    const double radius2_m2 = part.radius2_m2();
    // Bounds of heights are concave in time, so that their ends count.
    const double out_m = 0.5 * under.bump_per_m * radius2_m2 + k_touch_m;
    const double fallen = 0.5 * until_s * until_s;
    const auto stays_out = [&](const Above& point) {
      const double above_m = point.gap_m - out_m;
      return above_m > 0 &&
             above_m + point.rate_mps * until_s - fallen * pace_.fall_of(point, until_s) > 0;
    };
    if (std::ranges::all_of(part.outermost(), stays_out)) return true;
    const double radius_m = std::sqrt(radius2_m2);
    const double hurry_mps =
        pace_.bend_per_m * radius_m * (pace_.past_mps + pace_.turning_radps * radius_m);
    const auto parts = [&](const Above& point) {
      return point.rate_mps - hurry_mps - pace_.fall_of(point, until_s) * until_s > -k_approach_mps;
    };
    return std::ranges::all_of(part.outermost(), parts) ||
           is_above_lowest_until(part.outermost(), part.steps(), under.hollow_per_m, until_s) ||
           is_above_edge_until(part, under.hollow_per_m, until_s);
  }

  /// What the surface does where a part is, and comes until then.
  template <class Part>
  SurfaceBounds bounds_under(const Part& part, double until_s) {
    const std::span<const Above> points = part.outermost();
    Vec3 low_m = points[0].place_m;
    Vec3 high_m = low_m;
    for (const Above& point : points) {
      low_m = low_m.cwiseMin(point.place_m);
      high_m = high_m.cwiseMax(point.place_m);
    }
    const double way_m = pace_.past_mps * std::min(until_s, pace_.valid_s);
    return surface_.bounds_in(low_m.x() - way_m, high_m.x() + way_m, low_m.y() - way_m,
                              high_m.y() + way_m);
  }

  template <class Part>
  void visit(const Part& part) {
    if (part.steps() <= 1) return;
    const double until_s = horizon_s();
    const SurfaceBounds under = bounds_under(part, until_s);
    if (is_clear_until(part, under, until_s)) return;
    if (until_s > k_long_s && is_clear_until(part, under, k_long_enough * until_s)) {
      shortened_ = true;
      return;
    }
    split(
        points_, part, [&](const Above& point) { note(point); },
        [&](const Part& smaller) { visit(smaller); });
  }

  Points points_;
  SplineSurface& surface_;
  const BoxLattice& lattice_;
  const MovingPiece& box_;
  const Pace& pace_;
  Corners corners_;
  /// What others than the points that are near may do.
  struct Others {
    std::array<double, 8> left_m{};  ///< by corner
    std::array<double, 8> rate_mps{};
    double pull_mps2 = 0;
    double room_m = 0;
  };
  Others others_;
  double best_s_ = k_forever_s;    ///< no point that was looked at collides before
  double lowest_m_ = k_forever_s;  ///< gap of those
  bool shortened_ = false;         ///< what wasn't split is clear for a part of that time
  bool colliding_ = false;
  Above contact_;
};

PieceContact contact_from(const Above& point) {
  const Vec3 normal = point.normal();
  return {.gap_m = point.gap_m,
          .rate_mps = point.rate_mps * normal.z(),
          .normal = normal,
          .point_m = point.place_m - Vec3(0, 0, 0.5 * point.gap_m)};
}

}  // namespace

std::optional<BoxLattice> BoxLattice::of(const ConvexView& piece, double spacing_m) {
  if (piece.vertex_count != 8 || piece.face_count != 6) return std::nullopt;
  BoxLattice lattice;
  for (std::size_t e = 0; e < lattice.edges.size(); ++e) {
    const auto [one, other] = piece.edges[e].vertex;
    const double length_m = math::norm(piece.vertices_m[other] - piece.vertices_m[one]);
    // A whole number of steps remains one, whatever its length is rounded to.
    const double steps = std::ceil(length_m / spacing_m * (1 - k_parallel));
    if (!(steps <= k_steps_max)) return std::nullopt;
    lattice.edges[e] = {{one, other}, std::max(1, static_cast<std::int32_t>(steps))};
    lattice.steps_most = std::max(lattice.steps_most, lattice.edges[e].steps);
  }
  const auto side = [&](std::size_t f, std::size_t k) -> const Side& {
    return piece.sides[piece.faces[f].first_side + k];
  };
  const auto edge = [&](std::size_t f, std::size_t k) -> EdgeLattice& {
    return lattice.edges[side(f, k).edge];
  };
  for (std::size_t f = 0; f < 6; ++f) {
    if (piece.faces[f].side_count != 4) return std::nullopt;
    const auto vertex = [&](std::size_t k) { return piece.vertices_m[side(f, k).vertex]; };
    const Vec3 missing_m = (vertex(2) - vertex(3)) - (vertex(1) - vertex(0));
    if (math::norm(missing_m) > k_parallel * piece.r_outer_m) return std::nullopt;
  }
  // Opposite edges have as many steps, and so have all four that are parallel: the points of a
  // face then are those of its edges.
  for (int round = 0; round < 2; ++round) {
    for (std::size_t f = 0; f < 6; ++f) {
      for (std::size_t k = 0; k < 2; ++k) {
        EdgeLattice& one = edge(f, k);
        EdgeLattice& other = edge(f, k + 2);
        one.steps = other.steps = std::max(one.steps, other.steps);
      }
    }
  }
  for (std::size_t f = 0; f < 6; ++f) {
    FaceLattice& points = lattice.faces[f];
    for (std::size_t k = 0; k < 4; ++k)
      points.corner[k] = side(f, k).vertex;
    points.along = edge(f, 0).steps;
    points.across = edge(f, 1).steps;
  }
  return lattice;
}

Examined examine_surface(SplineSurface& surface, const BoxLattice& lattice, const MovingPiece& box,
                         Tick tick, NearPoints& near, PieceContact& contact) {
  const Pace pace = pace_of(surface, box);
  const double bottom_m = box.pose.position_m.z() - box.reach_m - k_touch_m;
  if (bottom_m > pace.surface.top_m) {
    // While the sphere around the box is higher than everything near.
    const double wide_m = box.reach_m + surface.spacing_m();
    const double clear_m = bottom_m - bounds_around(surface, box, wide_m).top_m;
    if (clear_m > 0) {
      const double span_s =
          std::min(stays_within_s(box, wide_m),
                   first_zero_s(clear_m, box.velocity_mps.z(), box.acceleration_mps2.z()));
      Examined apart = look_after(tick, span_s);
      apart.gap_m = clear_m;
      return apart;
    }
  }
  Look look(surface, lattice, box, pace);
  const double span_s = look.failing_s(near);
  if (look.collides()) {
    contact = contact_from(look.contact());
    return {.collides = true, .next = tick};
  }
  // No tick before the first one after this span.
  const TickCount span = ticks_after(span_s * (1 - k_skip_margin));
  return {.collides = false, .next = tick + std::max<TickCount>(1, span)};
}

PieceContact contact_of(SplineSurface& surface, const BoxLattice& lattice, const MovingPiece& box) {
  const Pace pace = pace_of(surface, box);
  Look look(surface, lattice, box, pace);
  look.failing_s();
  if (look.collides()) return contact_from(look.contact());
  Points points(surface, box);
  const Corners corners = corners_of(points);
  Above lowest = corners[0];
  visit_all_low(
      points, lattice, corners, pace.surface.bump_per_m, [&] { return lowest.gap_m; },
      [&](const Above& point) {
        if (point.gap_m < lowest.gap_m) lowest = point;
      });
  return contact_from(lowest);
}

void points_near(SplineSurface& surface, const BoxLattice& lattice, const MovingPiece& box,
                 double near_m, const std::function<void(const Vec3&, const Vec3&)>& found) {
  constexpr double k_half_root = 0.70710678118654752;
  constexpr std::array<std::array<double, 2>, k_outermost> k_ways{{{1, 0},
                                                                   {k_half_root, k_half_root},
                                                                   {0, 1},
                                                                   {-k_half_root, k_half_root},
                                                                   {-1, 0},
                                                                   {-k_half_root, -k_half_root},
                                                                   {0, -1},
                                                                   {k_half_root, -k_half_root}}};
  std::array<Above, k_outermost> outermost;
  std::array<double, k_outermost> out_m;
  out_m.fill(-k_forever_s);
  const Vec3& centre_m = box.pose.position_m;
  const auto note = [&](const Above& point) {
    if (point.gap_m > near_m) return;
    const Vec3 arm_m = point.place_m - centre_m;
    for (std::size_t k = 0; k < k_outermost; ++k) {
      const double way_m = arm_m.x() * k_ways[k][0] + arm_m.y() * k_ways[k][1];
      if (way_m <= out_m[k]) continue;
      out_m[k] = way_m;
      outermost[k] = point;
    }
  };
  Points points(surface, box);
  visit_all_low(
      points, lattice, corners_of(points), bounds_around(surface, box, 0).bump_per_m,
      [&] { return near_m; }, note);
  for (std::size_t k = 0; k < k_outermost; ++k) {
    const auto same = [&](const Above& other) { return other.place_m == outermost[k].place_m; };
    if (out_m[k] == -k_forever_s || std::any_of(outermost.begin(), outermost.begin() + k, same))
      continue;
    found(outermost[k].place_m, outermost[k].normal());
  }
}

}  // namespace sleight::physics
