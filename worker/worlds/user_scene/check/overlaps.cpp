#include "worker/worlds/user_scene/check/check.h"

#include <algorithm>
#include <deque>
#include <limits>
#include <memory>
#include <utility>

#include "worker/physics/collision/collision_rule.h"
#include "worker/physics/distance/round_distance.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/scene/static_geometry.h"
#include "worker/physics/scene/static_regions.h"

namespace sleight::worlds::user_scene {
namespace {

using physics::Box;
using physics::MovingPiece;

constexpr double k_apart_m = std::numeric_limits<double>::infinity();

/// A convex piece of a body.
struct Piece {
  physics::ConvexView view;
  MovingPiece shape;
  Box box;  ///< boxes of touching pieces overlap
};

/// Returns how far a piece reaches along a direction of the world.
double reach_m(const MovingPiece& piece, const Vec3& direction) {
  return math::dot(piece.pose.position_m, direction) +
         physics::reach_of_m(*piece.view,
                             physics::transposed_product(piece.pose.rotation, direction)) +
         piece.radius_m;
}

/// A deque, because the pieces point to their views.
std::deque<Piece> pieces_of(const physics::BodyDescription& body) {
  static const physics::PointPiece k_centre(Vec3::Zero());
  const auto* sphere = std::get_if<physics::Sphere>(&body.shape);
  const auto* compound = std::get_if<std::shared_ptr<const physics::Compound>>(&body.shape);
  const Pose pose{.position_m = body.start.pose.position_m,
                  .orientation = math::normalized(body.start.pose.orientation)};
  std::deque<Piece> all;
  for (std::size_t part = 0; part < (compound == nullptr ? 1 : (*compound)->size()); ++part) {
    Piece& piece = all.emplace_back();
    piece.view = compound == nullptr ? k_centre.view() : (*compound)->view(part);
    piece.shape = {.view = &piece.view,
                   .radius_m = sphere == nullptr ? 0 : sphere->radius_m,
                   .pose = physics::placed(pose),
                   .reach_m = physics::reach_m(body.shape)};
    Vec3 low_m, high_m;
    for (int axis = 0; axis < 3; ++axis) {
      low_m[axis] = -reach_m(piece.shape, -Vec3::Unit(axis));
      high_m[axis] = reach_m(piece.shape, Vec3::Unit(axis));
    }
    piece.box = physics::joined(physics::box_around(low_m), physics::box_around(high_m));
  }
  return all;
}

/// Returns the gap of deeply overlapping pieces, at least one of which is round. Climbs from the
/// best of 26 directions.
double deep_gap_m(const MovingPiece& a, const MovingPiece& b) {
  Vec3 best = Vec3::Zero();
  double gap_m = -k_apart_m;
  for (double step = 1; step > 1e-6;) {
    const Vec3 from = best;
    const double before_m = gap_m;
    for (int i = 0; i < 27; ++i) {
      const Vec3 to = from + step * Vec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
      if (math::norm(to) < 0.1) continue;
      const Vec3 n = math::normalized(to);
      const double separation_m = -reach_m(b, -n) - reach_m(a, n);
      if (!(separation_m > gap_m)) continue;
      gap_m = separation_m;
      best = n;
    }
    if (gap_m == before_m) step /= 2;
  }
  return gap_m;
}

double gap_m(const MovingPiece& a, const MovingPiece& b) {
  if (a.view->vertex_count == 1 && b.view->vertex_count == 1)
    return physics::gap_of_spheres_m(b.pose.position_m - a.pose.position_m,
                                     a.radius_m + b.radius_m);
  const double measured_m = physics::contact_of(a, b).gap_m;
  if (!physics::is_round(a) && !physics::is_round(b)) return measured_m;
  // Deeper than their margins, round pieces have no measured gap (round_distance.h).
  double margins_m = a.radius_m + b.radius_m;
  for (const MovingPiece* piece : {&a, &b})
    margins_m += physics::is_round(*piece) ? piece->view->round->margin_m() : 0;
  return measured_m > -0.999 * margins_m ? measured_m : deep_gap_m(a, b);
}

double gap_m(const std::deque<Piece>& a, const std::deque<Piece>& b) {
  double least_m = k_apart_m;
  for (const Piece& one : a) {
    for (const Piece& other : b) {
      if (physics::overlap(one.box, other.box))
        least_m = std::min(least_m, gap_m(one.shape, other.shape));
    }
  }
  return least_m;
}

double gap_m(const physics::StaticGeometry& geometry, const std::deque<Piece>& body) {
  double least_m = k_apart_m;
  for (const Piece& one : body) {
    std::vector<physics::StaticId> near;
    geometry.pieces_near(one.box, near);
    for (const physics::StaticId id : near)
      least_m = std::min(least_m, id < geometry.plane_count()
                                      ? physics::contact_of(geometry.plane({id}), one.shape).gap_m
                                      : gap_m(geometry.piece({id}), one.shape));
  }
  return least_m;
}

/// Returns a plane, static polyhedra or a mesh without the rest of the scene.
physics::StaticGeometry geometry_of(const BuiltScene& built, const Object& one) {
  physics::Scene alone;
  for (std::uint32_t i = one.first; i < one.first + one.count; ++i) {
    if (one.kind == ObjectKind::plane) alone.planes.push_back(built.scene.planes[i]);
    if (one.kind == ObjectKind::convex) alone.convexes.push_back(built.scene.convexes[i]);
    if (one.kind == ObjectKind::mesh) alone.meshes.push_back(built.scene.meshes[i]);
  }
  // Geometry has pieces only if a moving body is not a sphere.
  alone.bodies.emplace_back().shape = std::make_shared<const physics::Compound>();
  return physics::StaticGeometry(alone);
}

}  // namespace

std::vector<Overlap> overlaps_of(const BuiltScene& built) {
  const std::vector<physics::BodyDescription>& bodies = built.scene.bodies;
  std::vector<Overlap> found;
  const auto judge = [&](std::uint32_t a, std::uint32_t b, double gap_m, bool in_solid) {
    const bool touches = physics::touches(gap_m);
    const bool carried = bodies[a].rests && (b >= built.moving || bodies[b].rests);
    if (carried ? gap_m < -physics::k_at_rest_gap_m : touches || in_solid)
      found.push_back({a, b, std::max(-gap_m, 0.0),
                       in_solid && (!touches || built.objects[b].kind == ObjectKind::mesh)});
  };

  std::vector<std::deque<Piece>> pieces;
  for (const physics::BodyDescription& body : bodies)
    pieces.push_back(pieces_of(body));
  for (std::uint32_t a = 0; a < built.moving; ++a) {
    for (std::uint32_t b = a + 1; b < built.bodies; ++b) {
      const bool start_together = b >= built.moving || bodies[a].start_tick == bodies[b].start_tick;
      if (start_together && built.scene.filter.meet(bodies[a].group, bodies[b].group))
        judge(a, b, gap_m(pieces[a], pieces[b]), false);
    }
  }
  for (std::uint32_t object = built.bodies; object < built.objects.size(); ++object) {
    const physics::StaticGeometry geometry = geometry_of(built, built.objects[object]);
    for (std::uint32_t body = 0; body < built.moving; ++body) {
      // The simulator also refuses a body if only its centre of mass is inside a solid.
      if (built.scene.filter.meet(bodies[body].group, geometry.group_of_piece({0})))
        judge(body, object, gap_m(geometry, pieces[body]),
              geometry.solid_at(bodies[body].start.pose.position_m) != nullptr);
    }
  }
  std::ranges::sort(found, {}, [](const Overlap& one) { return std::pair(one.a, one.b); });
  return found;
}

}  // namespace sleight::worlds::user_scene
