#include "worker/physics/collision/surface_search.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "worker/physics/collision/first_collision.h"
#include "worker/physics/collision/surface_pace.h"
#include "worker/physics/collision/surface_points.h"
#include "worker/physics/event/tolerances.h"

namespace sleight::physics {
namespace {

using namespace surface_pace;
using namespace surface_points;

/// A face counts as a parallelogram if opposite sides differ by at most this share of the box's
/// size.
constexpr double k_parallel = 1e-9;
/// The search margins below affect only speed. Let t be the time for which all parts examined so
/// far are clear. A part that is clear for this share of t isn't split. If t is short, the part is
/// split anyway, because a collision is near.
constexpr double k_long_enough = 0.7;
constexpr double k_long_s = 3e-4;
/// If a point's first bound gives a time t, a second, tighter bound is computed for this many times
/// t.
constexpr double k_a_bit_more = 1.1;
/// A look with span t checks the near points for this many times t.
constexpr double k_clear_ahead = 4;
/// If the points that aren't stored stay clear for less than this, the near points are gathered
/// again.
constexpr double k_worth_s = 1e-4;
/// At a look with span t, a point is near if it may touch within this many times t.
constexpr double k_looks_ahead = 3;
constexpr double k_ahead_s_max = 2e-3;
/// Points closer than k_near_m_min always count as near. If near points could be further away than
/// k_near_share of the box's reach, no points are stored.
constexpr double k_near_m_min = 5e-6;
constexpr double k_near_share = 0.1;

class Look {
 public:
  Look(SplineSurface& surface, const BoxLattice& lattice, const MovingPiece& box, const Pace& pace,
       Tick tick = {})
      : points_(surface, box),
        surface_(surface),
        lattice_(lattice),
        box_(box),
        pace_(pace),
        tick_(tick) {}

  /// Returns a time before which no point collides, at most the time for which the pace holds. If a
  /// point collides now, returns 0, and contact() is that point.
  double failing_s() { return lowest_corner_counts() ? best_s_ : failing_of_all_s(); }
  /// Computes the time from points that earlier looks stored, if possible. Stores points for later
  /// looks.
  double failing_s(NearPoints& near) {
    if (near.known && see_descent(near)) {
      note_all(near);
      if (others_clear_until(best_s_)) return best_s_;
      const double others_s = others_failing_s();
      if (others_s >= k_worth_s) return std::min(best_s_, others_s);
    }
    if (lowest_corner_counts()) return best_s_;
    if (gather(near) && see_descent(near)) {
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
  /// Returns whether only the lowest corner can collide within the time that the corners allow. If
  /// the lowest corner doesn't settle the question, examines all corners.
  bool lowest_corner_counts() {
    best_s_ = pace_.valid_s;
    if (is_above_least_height()) return true;
    corners_ = corners_of(points_);
    for (const Above& corner : corners_)
      note(corner);
    return is_above_lowest_until(corners_, lattice_.steps_most, pace_.surface.hollow_per_m,
                                 horizon_s());
  }
  bool is_above_least_height() {
    std::array<Vec3, 8> places_m;
    std::size_t lowest = 0;
    for (std::size_t i = 0; i < places_m.size(); ++i) {
      places_m[i] = points_.place_m(box_.view->vertices_m[i]);
      if (places_m[i].z() < places_m[lowest].z()) lowest = i;
    }
    const Above least = points_.corner(lowest);
    note(least);
    const double until_s = horizon_s();
    const double by_m = needed_m(lattice_.steps_most, least.gap_m);
    for (std::size_t i = 0; i < places_m.size(); ++i) {
      if (i != lowest && !rises_until(places_m[i] - least.place_m, least.slope_x, least.slope_y,
                                      pace_.surface.hollow_per_m, by_m, until_s))
        return false;
    }
    return true;
  }
  double failing_of_all_s() {
    for (const EdgeLattice& edge : lattice_.edges)
      visit(Stretch{&edge, {0, edge.steps}, {corners_[edge.end[0]], corners_[edge.end[1]]}});
    for (const FaceLattice& face : lattice_.faces)
      visit(cell_of(face, corners_));
    return shortened_ ? k_long_enough * best_s_ : best_s_;
  }

  /// Examines the near points that may touch before the earliest known collision.
  void note_all(NearPoints& near) {
    best_s_ = pace_.valid_s;
    note_those(near, [&](Tick clear_until) { return clear_until <= tick_; });
    note_those(near, [&](Tick clear_until) {
      return clear_until > tick_ && seconds(clear_until - tick_) < best_s_;
    });
  }
  template <class IsDue>
  void note_those(NearPoints& near, const IsDue& is_due) {
    double until_s = best_s_;
    double share = share_at(until_s);
    for (std::size_t i = 0; i < near.count; ++i) {
      if (best_s_ < until_s) {
        until_s = best_s_;
        share = share_at(until_s);
      }
      if (near.share[i] > share) return;
      if (!is_due(near.clear_until[i])) continue;
      Above point = points_.above(near.own_m[i]);
      point.order = near.order[i];
      const double clear_s = clear_for_s(point, std::min(pace_.valid_s, k_clear_ahead * best_s_));
      near.clear_until[i] = tick_ + ticks_after(clear_s * (1 - k_skip_margin));
      best_s_ = std::min(best_s_, clear_s);
      note_contact(point);
    }
  }
  /// Updates how far each corner has come down since the near points were gathered. Returns false
  /// if points that aren't stored may touch.
  bool see_descent(const NearPoints& near) {
    const double pull_mps2 =
        std::max(0.0, -box_.acceleration_mps2.z()) + box_.turning_acceleration_mps2;
    const double aside_mps = near.slope * pace_.past_mps;
    descent_.room_m = near.room_m;
    for (std::size_t i = 0; i < near.corners_m.size(); ++i) {
      const Vec3 place_m = points_.place_m(box_.view->vertices_m[i]);
      const Vec3 moved_m = place_m - near.corners_m[i];
      const double gone_m = std::fabs(moved_m.x()) + std::fabs(moved_m.y());  // an upper bound
      descent_.by[i] = (near.slope * gone_m - moved_m.z()) * near.per_allowed[i];
      descent_.rate_per_s[i] = (aside_mps - upwards_mps(place_m)) * near.per_allowed[i];
      descent_.pull_per_s2[i] = pull_mps2 * near.per_allowed[i];
      descent_.room_m = std::min(descent_.room_m, near.room_m - gone_m);
      if (descent_.by[i] >= 1) return false;
    }
    return descent_.room_m > 0;
  }
  /// Computes, for each corner, the share of its room that the corner uses up by `until_s`. Returns
  /// the greatest share. The share is convex in time, so its maximum is at one of the ends.
  double share_at(double until_s) const {
    const double half_s = 0.5 * until_s;
    double most = -k_forever_s;
    for (std::size_t i = 0; i < descent_.by.size(); ++i) {
      const double more = (descent_.rate_per_s[i] + descent_.pull_per_s2[i] * half_s) * until_s;
      most = std::max(most, descent_.by[i] + std::max(0.0, more));
    }
    return most;
  }
  bool others_clear_until(double until_s) const {
    return share_at(until_s) < 1 && descent_.room_m > pace_.past_mps * until_s;
  }
  /// Returns how long the points that aren't stored stay clear.
  double others_failing_s() const {
    double until_s = pace_.past_mps > 0 ? descent_.room_m / pace_.past_mps : k_forever_s;
    for (std::size_t i = 0; i < descent_.by.size(); ++i) {
      const double left = 1 - descent_.by[i];
      const double rate_per_s = descent_.rate_per_s[i];
      const double root = std::sqrt(rate_per_s * rate_per_s + 2 * descent_.pull_per_s2[i] * left);
      if (rate_per_s + root > 0) until_s = std::min(until_s, 2 * left / (rate_per_s + root));
    }
    return until_s;
  }
  double upwards_mps(const Vec3& place_m) const {
    const Vec3 arm_m = place_m - box_.pose.position_m;
    return box_.velocity_mps.z() + math::cross(box_.angular_velocity_radps, arm_m).z();
  }
  /// Stores the points that this look and a few similar looks need. Returns false if there are too
  /// many such points.
  bool gather(NearPoints& near) {
    near.known = false;
    const double span_s = k_looks_ahead * std::min(best_s_, k_ahead_s_max);
    const double aside_mps = pace_.surface.slope * pace_.past_mps + pace_.fall_mps2 * span_s;
    double most_m = 0;
    Corners corners = corners_;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      near.corners_m[i] = corners[i].place_m;
      near.allowed_m[i] =
          std::max(k_near_m_min, (std::fabs(upwards_mps(corners[i].place_m)) + aside_mps) * span_s);
      corners[i].allowed_m = near.allowed_m[i];
      near.per_allowed[i] = 1 / near.allowed_m[i];
      most_m = std::max(most_m, near.allowed_m[i]);
    }
    if (most_m > k_near_share * box_.reach_m) return false;
    near.slope = pace_.surface.slope;
    near.room_m = k_room * box_.reach_m;
    near.count = 0;
    bool fits = true;
    Points points(surface_, box_, near.allowed_m);
    visit_all_low(
        points, lattice_, corners, pace_.surface.bump_per_m,
        [&] { return fits ? 2 * k_touch_m : -k_forever_s; },
        [&](const Above& point) {
          if (point.spare_m() > 2 * k_touch_m || !fits) return;
          const auto kept = std::span(near.own_m).first(near.count);
          if (std::ranges::find(kept, point.own_m) != kept.end()) return;
          fits = near.count < NearPoints::k_most;
          if (fits) near.keep(point.own_m, (point.gap_m - 2 * k_touch_m) / point.allowed_m);
        });
    near.known = fits;
    return fits;
  }

  /// Returns the time for which parts are examined, at least one tick.
  double horizon_s() const { return std::max(best_s_, k_seconds_per_tick); }

  /// Returns a time before which a point can't collide, at most `until_s`.
  double collides_after_s(const Above& point, double until_s) const {
    return std::min(until_s, first_collision_s(point.gap_m - pace_.rounding_m,
                                               point.rate_mps - pace_.rounding_mps,
                                               pace_.fall_of(point.pull_mps2, until_s), 0));
  }
  /// collides_after_s with tighter bounds.
  double clear_for_s(const Above& point, double until_s) const {
    // The bound is concave in time. So if it excludes a touch at both ends, it excludes a touch
    // between them.
    const double fall_mps = 0.5 * pace_.fall_of(point.pull_mps2, until_s) * until_s;
    const double clear_m = point.gap_m - pace_.rounding_m - k_touch_m;
    if (clear_m > 0 && clear_m + (point.rate_mps - fall_mps) * until_s > 0) return until_s;
    const double soon_s = collides_after_s(point, until_s);
    // A bound for a shorter time is tighter.
    return soon_s < until_s ? collides_after_s(point, std::min(until_s, k_a_bit_more * soon_s))
                            : until_s;
  }

  void note(const Above& point) {
    best_s_ = clear_for_s(point, best_s_);
    note_contact(point);
  }
  void note_contact(const Above& point) {
    lowest_m_ = std::min(lowest_m_, point.gap_m);
    if (!point.collides()) return;
    if (colliding_ && (point.gap_m > contact_.gap_m ||
                       (point.gap_m == contact_.gap_m && point.order >= contact_.order)))
      return;
    colliding_ = true;
    contact_ = point;
  }

  /// Returns how much higher than the lowest point a far end must be. The points between them then
  /// stay clear of the surface, unless the lowest point collides. Each of these points is at least
  /// 1 / steps of the way from the lowest point.
  double needed_m(std::int32_t steps, double gap_m) const {
    return steps * (2 * k_touch_m + std::max(0.0, -std::min(gap_m, lowest_m_)));
  }
  /// Let p be a point, with the given slopes. Returns whether p + d stays at least `by_m` higher
  /// than p until `until_s`. Allows for the turn of d, and for changes of the slopes at p.
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

  /// `points` are the ends or corners of a part of the lattice, `steps` the number of lattice steps
  /// between the ends. Returns true if no lattice point of this part can collide before `until_s`,
  /// unless the lowest of `points` collides too.
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
  /// Returns true for a cell next to an edge of the box, if the cell can't collide before `until_s`
  /// unless a point of the edge collides too.
  bool is_above_edge_until(const Cell& cell, double hollow_per_m, double until_s) const {
    for (std::size_t side = 0; side < 4; ++side) {
      if (!cell.is_outer(side)) continue;
      const Above& one = cell.corners[side];
      const Above& other = cell.corners[(side + 1) % 4];
      const Vec3 across_m = cell.corners[(side + 3) % 4].place_m - one.place_m;
      // At each point of the side, use the slopes at the nearer end; `by_m` covers the difference.
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

  /// Returns whether no point between the ends or corners of a part collides within `until_s`.
  template <class Part>
  bool is_clear_until(const Part& part, const SurfaceBounds& under, double until_s) const {
    const double radius2_m2 = part.radius2_m2();
    // Bounds of heights are concave in time, so it is enough to check now and `until_s`.
    const double out_m = 0.5 * under.bump_per_m * radius2_m2 + k_touch_m + pace_.rounding_m;
    const double fallen = 0.5 * until_s * until_s;
    const auto stays_out = [&](const Above& point) {
      const double above_m = point.gap_m - out_m;
      return above_m > 0 &&
             above_m + point.rate_mps * until_s - fallen * pace_.fall_of(point.pull_mps2, until_s) >
                 0;
    };
    if (std::ranges::all_of(part.outermost(), stays_out)) return true;
    const double radius_m = std::sqrt(radius2_m2);
    const double hurry_mps =
        pace_.bend_per_m * radius_m * (pace_.past_mps + pace_.turning_radps * radius_m);
    const auto parts = [&](const Above& point) {
      return point.rate_mps - hurry_mps - pace_.fall_of(point.pull_mps2, until_s) * until_s >
             -k_approach_mps;
    };
    return std::ranges::all_of(part.outermost(), parts) ||
           is_above_lowest_until(part.outermost(), part.steps(), under.hollow_per_m, until_s) ||
           is_above_edge_until(part, under.hollow_per_m, until_s);
  }

  /// Returns bounds of the surface below every place that the part may reach until `until_s`.
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
    if (is_clear_until(part, pace_.surface, until_s)) return;
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
  Tick tick_;
  Corners corners_;
  /// Upper bounds on how far each corner has come down, as a share of its room.
  struct Descent {
    std::array<double, 8> by{};  ///< until now; negative where a corner has risen
    std::array<double, 8> rate_per_s{};
    std::array<double, 8> pull_per_s2{};
    double room_m = 0;
  };
  Descent descent_;
  double best_s_ = k_forever_s;    ///< no examined point collides before this
  double lowest_m_ = k_forever_s;  ///< least gap of the examined points
  bool shortened_ = false;         ///< some unsplit part is clear only for a share of best_s_
  bool colliding_ = false;
  Above contact_;
};

PieceContact contact_from(const Above& point) {
  const Vec3 normal = point.normal();
  return {.gap_m = point.gap_m,
          .rate_mps = rate_along_normal_mps(point.rate_mps, normal),
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
    // The factor avoids an extra step that is only due to rounding.
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
  // Give parallel edges equally many steps. Then the border points of a face are the points of its
  // edges.
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

void NearPoints::keep(const Vec3& point_m, double of_share) {
  std::size_t place = count;
  for (; place > 0 && share[place - 1] > of_share; --place) {
    own_m[place] = own_m[place - 1];
    order[place] = order[place - 1];
    share[place] = share[place - 1];
  }
  clear_until[count] = Tick{};
  own_m[place] = point_m;
  order[place] = static_cast<std::uint32_t>(count);
  share[place] = of_share;
  ++count;
}

Examined examine_surface(SplineSurface& surface, const BoxLattice& lattice, const MovingPiece& box,
                         Tick tick, NearPoints& near, PieceContact& contact) {
  const Pace pace = pace_of(surface, box);
  const double bottom_m = box.pose.position_m.z() - box.reach_m - k_touch_m;
  if (bottom_m > pace.surface.top_m) {
    // The box is clear while its bounding sphere is higher than the whole surface nearby.
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
  Look look(surface, lattice, box, pace, tick);
  const double span_s = look.failing_s(near);
  if (look.collides()) {
    contact = contact_from(look.contact());
    return {.collides = true, .next = tick};
  }
  // The next look is at most at the first tick after this span.
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
  constexpr std::array<std::array<double, 2>, k_surface_points_max> k_ways{
      {{1, 0},
       {k_half_root, k_half_root},
       {0, 1},
       {-k_half_root, k_half_root},
       {-1, 0},
       {-k_half_root, -k_half_root},
       {0, -1},
       {k_half_root, -k_half_root}}};
  std::array<Above, k_surface_points_max> outermost;
  std::array<double, k_surface_points_max> out_m;
  out_m.fill(-k_forever_s);
  const Vec3& centre_m = box.pose.position_m;
  const auto note = [&](const Above& point) {
    if (point.gap_m > near_m) return;
    const Vec3 arm_m = point.place_m - centre_m;
    for (std::size_t k = 0; k < k_surface_points_max; ++k) {
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
  for (std::size_t k = 0; k < k_surface_points_max; ++k) {
    const auto same = [&](const Above& other) { return other.place_m == outermost[k].place_m; };
    if (out_m[k] == -k_forever_s || std::any_of(outermost.begin(), outermost.begin() + k, same))
      continue;
    found(outermost[k].place_m, outermost[k].normal());
  }
}

}  // namespace sleight::physics
