// Rest events and mode events. Also finds corners that carry a body but have no recorded touch.
#include <algorithm>
#include <array>
#include <limits>

#include "worker/physics/collision/piece_corners.h"
#include "worker/physics/contact/contact_events.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/simulator/world.h"
#include "worker/physics/simulator/world_at_event.h"

namespace sleight::physics {
namespace {

/// Calls found(corner, normal) for each corner of piece `of` that is close to piece `near`: close
/// to a face or, if `near` is round, to its surface. The normal points out of `near`. `direction`
/// points from `of` to `near`.
template <class Found>
void corners_near(const MovingPiece& of, const MovingPiece& near, const Vec3& direction,
                  double near_m, const Found& found) {
  for_each_corner(of, direction, near_m, [&](const Vec3& corner_m) {
    if (is_round(near)) {
      const PointPiece point(corner_m);
      const ConvexView view = point.view();
      const Closest closest = closest_round(*near.view, near.pose, view, {});
      if (closest.gap_m <= near_m) found(corner_m, closest.normal);
      return;
    }
    const Vec3 local_m = transposed_product(near.pose.rotation, corner_m - near.pose.position_m);
    const Vec3 towards = transposed_product(near.pose.rotation, direction);
    double above_m = -std::numeric_limits<double>::infinity();
    // Several faces may be near, even side faces. Choose the one most opposed to `direction`.
    std::size_t face = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < near.view->face_count && above_m <= near_m; ++k) {
      const Face& one = near.view->faces[k];
      const double height_m = math::dot(one.normal, local_m) - one.offset_m;
      above_m = std::max(above_m, height_m);
      const double along = math::dot(one.normal, towards);
      if (height_m < -near_m || along >= least) continue;
      least = along;
      face = k;
    }
    if (above_m <= near_m && least < 0)
      found(corner_m, math::product(near.pose.rotation, near.view->faces[face].normal));
  });
}

}  // namespace

std::size_t World::rest(BodyId body, const EventKey& event) {
  AtEvent at(*this, event);
  return contact::rest(at, body);
}

void World::change_mode(BodyId body, const EventKey& event) {
  AtEvent at(*this, event);
  contact::change_mode(at, body);
}

void World::note_near_corners(BodyId body, Tick tick) {
  resting_.forget_old_touches(body, tick);
  // Copy the list, because the loop changes it.
  std::array<TouchRecord, k_touch_records_max> copy;
  const auto end = std::ranges::copy(resting_.touches(body), copy.begin()).out;
  for (auto touch = copy.begin(); touch != end; ++touch) {
    const bool seen = std::any_of(copy.begin(), touch, [&](const TouchRecord& earlier) {
      return earlier.partner == touch->partner && earlier.feature == touch->feature &&
             math::dot(earlier.normal, touch->normal) > k_same_face_cosine;
    });
    if (seen) continue;
    corners_like(body, *touch, tick, k_near_corner * bodies_.constants(body).reach_m,
                 [this, body](const TouchRecord& near) { resting_.still_touches(body, near); });
  }
}

void World::corners_like(BodyId body, const TouchRecord& touch, Tick tick, double near_m,
                         const std::function<void(const TouchRecord&)>& found) {
  const Vec3 centre_m = bodies_.position_at(body, tick);
  const bool has_map = touch.partner == k_static_partner &&
                       !statics_.is_surface(body, touch.feature) &&
                       statics_.geometry().friction_map(touch.feature) != nullptr;
  const auto note = [&](const Vec3& at_m, const Vec3& normal) {
    if (math::dot(normal, touch.normal) < k_same_face_cosine) return;
    TouchRecord near = touch;
    near.tick = tick;
    near.normal = normal;
    near.arm_m = at_m - centre_m;
    if (has_map) near.friction = statics_.law(body, touch.feature, at_m).friction;
    found(near);
  };
  const auto note_both = [&](const MovingPiece& own, const MovingPiece& other) {
    corners_near(own, other, -touch.normal, near_m, note);
    corners_near(other, own, touch.normal, near_m,
                 [&](const Vec3& at_m, const Vec3& normal) { note(at_m, -normal); });
  };
  for (std::uint32_t part = 0; part < bodies_.constants(body).part_count; ++part) {
    const MovingPiece own = bodies_.part_at(body, part, tick);
    if (touch.partner != k_static_partner) {
      if (bodies_.constants(touch.partner).is_sphere) return;
      for (std::uint32_t of_other = 0; of_other < bodies_.constants(touch.partner).part_count;
           ++of_other)
        note_both(own, bodies_.part_at(touch.partner, of_other, tick));
    } else if (statics_.is_surface(body, touch.feature)) {
      points_near(statics_.surface(touch.feature).surface,
                  statics_.lattice_on(touch.feature, body, part), own, near_m, note);
    } else if (touch.feature >= statics_.geometry().plane_count()) {
      note_both(own, statics_.geometry().piece({touch.feature}));
    } else {
      const HalfSpace& solid = statics_.geometry().plane({touch.feature});
      for_each_corner(own, -solid.normal, near_m, [&](const Vec3& corner_m) {
        if (math::dot(solid.normal, corner_m) - solid.offset_m <= near_m)
          note(corner_m, solid.normal);
      });
    }
  }
}

}  // namespace sleight::physics
