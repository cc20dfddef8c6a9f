#include "worker/physics/distance/round_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/physics/distance/gjk.h"
#include "worker/physics/distance/separation.h"

namespace sleight::physics {
namespace {

using math::cross;
using math::dot;
using math::norm;

/// The search ends when its lower bound is this close to the distance. The value is relative to the
/// sum of the pieces' sizes and their distance.
constexpr double k_reached = 0x1p-46;

double margin_of(const ConvexView& piece) {
  return piece.round != nullptr ? piece.round->margin_m() : 0;
}
/// Returns a unit vector perpendicular to another unit vector.
Vec3 across_of(const Vec3& axis) {
  const Vec3 other = std::fabs(axis.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY();
  return math::normalized(cross(axis, other));
}

/// Reduces a round piece by `margin_m`. Returns the reduced piece's furthest point along a unit
/// direction.
Vec3 support_of(const RoundPiece& piece, const Vec3& u, double margin_m) {
  const Vec3& axis = piece.axis();
  // Project twice, so that even a short vector is exactly perpendicular.
  const Vec3 once = u - dot(axis, u) * axis;
  const Vec3 part = once - dot(axis, once) * axis;
  const double across = norm(part);
  const RoundFeature* best = nullptr;
  double most_m = -std::numeric_limits<double>::infinity();
  piece.for_each_reach(u, across, [&](const RoundFeature& feature, double reach_m) {
    if (reach_m <= most_m) return;
    most_m = reach_m;
    best = &feature;
  });
  Vec3 point = best->centre_m + (best->radius_m - margin_m) * u;
  // If the component across the axis is shorter, it is only rounding, and the ring lies flat.
  if (across > 1e-14) point += (best->circle_m / across) * part;
  return point;
}

/// support_of for any piece.
Vec3 core_support(const ConvexView& piece, const Vec3& u, double margin_m) {
  return piece.round != nullptr ? support_of(*piece.round, u, margin_m)
                                : piece.vertices_m[furthest_vertex(piece, u)];
}

/// The gap and normal of a point and a piece of revolution, in the piece's frame.
struct PointGap {
  double gap_m = -std::numeric_limits<double>::infinity();
  Vec3 normal = Vec3::Zero();  ///< from the piece to the point
};
PointGap gap_of_point(const RoundPiece& piece, const Vec3& point_m) {
  const Vec3& axis = piece.axis();
  const Vec3 from = point_m - piece.origin_m();
  const double along_m = dot(axis, from);
  const Vec3 part = from - along_m * axis;
  const double across_m = norm(part);
  PointGap best;
  ProfileNormal best_normal{};
  const auto offer = [&](const ProfileNormal& e) {
    double reach_m = -std::numeric_limits<double>::infinity();
    for (const ProfileArc& arc : piece.arcs()) {
      const RoundFeature& disc = piece.features()[arc.feature];
      reach_m =
          std::max(reach_m, (e.across * disc.circle_m + e.along * disc.height_m) + disc.radius_m);
    }
    const double gap_m = (e.across * across_m + e.along * along_m) - reach_m;
    if (gap_m <= best.gap_m) return;
    best.gap_m = gap_m;
    best_normal = e;
  };
  for (const ProfileNormal& flat : piece.flats())
    offer(flat);
  for (const ProfileArc& arc : piece.arcs()) {
    const RoundFeature& disc = piece.features()[arc.feature];
    const double x = across_m - disc.circle_m;
    const double z = along_m - disc.height_m;
    const double length = std::sqrt(x * x + z * z);
    if (!(length > 0)) {
      offer({1, 0});
    } else if (x >= 0) {
      offer({x / length, z / length});
    } else {
      offer({0, std::copysign(1.0, z)});
    }
  }
  const Vec3 outwards = across_m > 0 ? Vec3(part / across_m) : across_of(axis);
  best.normal = best_normal.across * outwards + best_normal.along * axis;
  return best;
}

/// Computes the closest points of a point and a piece of revolution in closed form.
Closest closest_to_revolution(const RoundPiece& piece, const PlacedPose& pose, const Vec3& point_m,
                              bool point_is_b) {
  const PointGap gap =
      gap_of_point(piece, transposed_product(pose.rotation, point_m - pose.position_m));
  const Vec3 normal = math::product(pose.rotation, gap.normal);
  const Vec3 on_piece_m = point_m - gap.gap_m * normal;
  Closest closest;
  closest.gap_m = gap.gap_m;
  closest.normal = point_is_b ? normal : Vec3(-normal);
  closest.point_a_m = point_is_b ? on_piece_m : point_m;
  closest.point_b_m = point_is_b ? point_m : on_piece_m;
  return closest;
}

bool is_point(const ConvexView& piece) {
  return piece.round == nullptr && piece.vertex_count == 1;
}

/// Reduces both pieces by their margins and runs GJK on them, in A's frame.
class Descent {
 public:
  Descent(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
          const PlacedPose& pose_b)
      : a_(&a),
        b_(&b),
        b_in_a_(relative_pose(pose_a, pose_b)),
        margin_a_m_(margin_of(a)),
        margin_b_m_(margin_of(b)),
        error_m_(k_reached * (a.r_outer_m + b.r_outer_m + norm(b_in_a_.position_m))) {}

  void run() {
    Vec3 way = to_world(b_in_a_, b_->centre_m) - a_->centre_m;
    if (!(norm(way) > 0)) way = Vec3::UnitX();
    // If rounding stopped the descent, restart from its end, so that all points are near the end.
    constexpr int k_restarts = 3;
    double reached_m = descend(way);
    for (int i = 0; i < k_restarts && !overlap_ && reached_m - gap_m_ > error_m_; ++i) {
      const Descent before = *this;
      simplex_.count = 0;
      reached_m = std::min(reached_m, descend(normal_));
      if (overlap_) {  // by rounding
        *this = before;
        break;
      }
      if (reached_m - gap_m_ > error_m_) climb(reached_m);
      if (!(gap_m_ > before.gap_m_)) break;
    }
  }

  Closest result(const PlacedPose& pose_a) const {
    Vec3 on_a = Vec3::Zero();
    Vec3 on_b = Vec3::Zero();
    for (int i = 0; i < simplex_.count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      on_a += simplex_.weights[k] * points_[simplex_.points[k].a].on_a;
      on_b += simplex_.weights[k] * points_[simplex_.points[k].a].on_b;
    }
    Closest closest;
    closest.gap_m = gap_m_ - (margin_a_m_ + margin_b_m_);
    closest.normal = math::product(pose_a.rotation, normal_);
    closest.point_a_m = to_world(pose_a, on_a + margin_a_m_ * normal_);
    closest.point_b_m = to_world(pose_a, on_b - margin_b_m_ * normal_);
    return closest;
  }

 private:
  struct Supports {
    Vec3 on_a;
    Vec3 on_b;
  };
  /// Computes each piece's furthest point towards the other piece along the axis n. Returns the
  /// lower bound of the gap that these two points give. If the bound is the greatest so far, stores
  /// it.
  double ask(const Vec3& n, Supports& points) {
    points.on_a = core_support(*a_, n, margin_a_m_);
    points.on_b =
        to_world(b_in_a_, core_support(*b_, -transposed_product(b_in_a_.rotation, n), margin_b_m_));
    const double bound_m = dot(n, points.on_b - points.on_a);
    if (bound_m > gap_m_) {
      gap_m_ = bound_m;
      normal_ = n;
    }
    return bound_m;
  }

  /// Runs GJK from a first direction and returns the distance that GJK reaches.
  double descend(Vec3 way) {
    double length_m = std::numeric_limits<double>::infinity();
    for (int i = 0; i < k_gjk_iterations_max; ++i) {
      const std::uint16_t slot = free_slot();
      const double bound_m = ask(way / norm(way), points_[slot]);
      if (simplex_.count > 0 && length_m - bound_m <= error_m_) break;
      const Simplex before = simplex_;
      simplex_.points[static_cast<std::size_t>(simplex_.count++)] = {
          .difference_m = points_[slot].on_b - points_[slot].on_a, .a = slot, .b = slot};
      Vec3 closer;
      const bool apart = reduce(simplex_, closer);
      const double closer_m = apart ? norm(closer) : 0;
      if (!(closer_m > 0)) {
        overlap_ = true;
        gap_m_ = 0;
        simplex_.count = 1;
        simplex_.weights[0] = 1;
        break;
      }
      // Rounding prevents further progress.
      if (before.count > 0 && !(closer_m < length_m)) {
        simplex_ = before;
        break;
      }
      way = closer;
      length_m = closer_m;
    }
    return length_m;
  }

  /// Climbs to the bound's maximum. Used if rounding stopped the descent before the bound reached
  /// the distance.
  void climb(double reached_m) {
    constexpr int k_steps = 40;
    double pace = 1 / (a_->r_outer_m + b_->r_outer_m);
    Supports points = points_[0];
    Vec3 n = normal_;
    double best_m = ask(n, points);
    for (int i = 0; i < k_steps && reached_m - best_m > error_m_; ++i) {
      const Vec3 between_m = points.on_b - points.on_a;
      const Vec3 slope_m = between_m - dot(n, between_m) * n;
      Supports next;
      const Vec3 other = math::normalized(n + pace * slope_m);
      const double bound_m = ask(other, next);
      if (bound_m > best_m) {
        best_m = bound_m;
        n = other;
        points = next;
        pace *= 2;
      } else {
        pace *= 0.25;
      }
    }
  }

  /// Returns a free slot. The simplex uses at most four of the five slots.
  std::uint16_t free_slot() const {
    for (std::uint16_t slot = 0; slot < points_.size(); ++slot) {
      bool used = false;
      for (int i = 0; i < simplex_.count; ++i)
        used = used || simplex_.points[static_cast<std::size_t>(i)].a == slot;
      if (!used) return slot;
    }
    return 0;
  }

  const ConvexView* a_;
  const ConvexView* b_;
  PlacedPose b_in_a_;
  double margin_a_m_;
  double margin_b_m_;
  double error_m_;
  std::array<Supports, 5> points_;
  Simplex simplex_;
  Vec3 normal_ = Vec3::UnitX();
  double gap_m_ = -std::numeric_limits<double>::infinity();
  bool overlap_ = false;
};

}  // namespace

double reach_of_m(const ConvexView& piece, const Vec3& direction) {
  if (piece.round != nullptr) return piece.round->reach_m(direction);
  double most_m = dot(piece.vertices_m[0], direction);
  for (std::size_t i = 1; i < piece.vertex_count; ++i)
    most_m = std::max(most_m, dot(piece.vertices_m[i], direction));
  return most_m;
}

Closest closest_round(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                      const PlacedPose& pose_b) {
  if (is_point(b) && a.round->of_revolution())
    return closest_to_revolution(*a.round, pose_a, to_world(pose_b, b.vertices_m[0]), true);
  if (is_point(a) && b.round->of_revolution())
    return closest_to_revolution(*b.round, pose_b, to_world(pose_a, a.vertices_m[0]), false);
  Descent descent(a, pose_a, b, pose_b);
  descent.run();
  return descent.result(pose_a);
}

Closest closest_round_to_plane(const Vec3& normal, double offset_m, const ConvexView& piece,
                               const PlacedPose& pose) {
  const Vec3 down = -transposed_product(pose.rotation, normal);
  const Vec3 lowest_m = to_world(pose, support_of(*piece.round, down, 0));
  const double gap_m = (dot(normal, pose.position_m) - offset_m) - piece.round->reach_m(down);
  Closest closest;
  closest.gap_m = gap_m;
  closest.normal = normal;
  closest.point_b_m = lowest_m;
  closest.point_a_m = lowest_m - gap_m * normal;
  return closest;
}

}  // namespace sleight::physics
