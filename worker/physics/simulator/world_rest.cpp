// Which bodies go to rest, which lasting contacts carry them beside those that they touched, and
// which bodies wake.
#include <algorithm>
#include <limits>

#include "worker/physics/simulator/world.h"

namespace sleight::physics {
namespace {

/// Corners near a touch (k_near_corner) carry only where both touch the same face: normals this
/// much alike.
constexpr double k_same_face_cosine = 0.98;

/// Calls found(corner, normal of the face) for the corners of a piece that are near a face of
/// another one; the normal points out of that.
template <class Found>
void corners_near(const MovingPiece& of, const MovingPiece& near, double near_m,
                  const Found& found) {
  for (std::size_t i = 0; i < of.view->vertex_count; ++i) {
    const Vec3 corner_m = to_world(of.pose, of.view->vertices_m[i]);
    const Vec3 local_m = transposed_product(near.pose.rotation, corner_m - near.pose.position_m);
    double above_m = -std::numeric_limits<double>::infinity();
    std::size_t face = 0;
    for (std::size_t k = 0; k < near.view->face_count && above_m <= near_m; ++k) {
      const double height_m =
          math::dot(near.view->faces[k].normal, local_m) - near.view->faces[k].offset_m;
      if (height_m <= above_m) continue;
      above_m = height_m;
      face = k;
    }
    if (above_m <= near_m)
      found(corner_m, math::product(near.pose.rotation, near.view->faces[face].normal));
  }
}

}  // namespace

std::size_t World::rest(std::uint32_t body, const EventKey& event) {
  changed_.clear();
  const auto present = [&](std::uint32_t member) {
    // Its partners are asked next, and it may come to rest on them.
    note_contact_state(member);
    resting_.for_each_partner(member, event.tick, [&](std::uint32_t partner) {
      make_live(partner);
      if (history_builder_) history_builder_->takes_part(partner);
    });
    const bool stays = stays_on_faces(member);
    for (std::uint32_t i = 0; stays && i < supports_[member].count; ++i) {
      resting_.still_touches(member,
                             touch_of_support(member, supports_[member].features[i], event.tick));
    }
    if (!constants_[member].is_sphere) note_near_corners(member, event.tick);
    return Resting::Present{
        .speed_mps = fastest_point_mps(member, twist_at(member, event.tick)),
        .weight_n = constants_[member].inertia.mass_kg * scene_.gravity_mps2,
        .reach_m = constants_[member].reach_m,
        .centre_m = position_at(segments_[member].flight, event.tick),
        .round = constants_[member].is_sphere,
        .stance = stays ? stance_of(member, event.tick) : Resting::Stance::unknown};
  };
  for (const std::uint32_t member : resting_.decide(body, event.tick, present)) {
    Segment segment =
        segment_after(member, event.tick, position_at(segments_[member].flight, event.tick), {});
    segment.flight.acceleration_mps2 = Vec3::Zero();
    segment.mode = MotionMode::resting;
    begin_segment(member, segment, event);
    changed_.push_back(member);
  }
  const std::size_t count = changed_.size();
  if (count == 0 && has_left(body, event.tick)) {
    resting_.leave(body);
    wake_dependents(body, event);
  }
  return count;
}

Resting::Stance World::stance_of(std::uint32_t body, Tick tick) {
  const std::span<const std::uint32_t> features = supports_[body].all();
  std::array<LastingContact, 3> contacts;
  for (std::size_t i = 0; i < features.size(); ++i)
    contacts[i] = lasting_contact(body, features[i], tick);
  if (stands_on(round_body(body), std::span(contacts).first(features.size()), scene_.gravity_mps2))
    return Resting::Stance::holds;
  return resting_.touched_only(body, tick, features) ? Resting::Stance::slides
                                                     : Resting::Stance::unknown;
}

void World::wake_dependents(std::uint32_t body, const EventKey& event) {
  for (const std::uint32_t dependent : resting_.wake(body)) {
    make_live(dependent);
    note_contact_state(dependent);
    if (!is_resting(dependent)) continue;
    begin_after(dependent, {}, event);
    const FreeFlight& flight = segments_[dependent].flight;
    // How a sphere is turned makes no difference.
    const bool round = constants_[dependent].is_sphere;
    resting_.woke(dependent, event.tick,
                  {flight.position_m, round ? Quat::Identity() : flight.orientation});
  }
}

bool World::has_left(std::uint32_t body, Tick tick) {
  if (!resting_.in_place(body)) return false;
  const double speed_mps = fastest_point_mps(body, twist_at(body, tick));
  const Pose pose = constants_[body].is_sphere
                        ? Pose{position_at(segments_[body].flight, tick), Quat::Identity()}
                        : pose_at(body, tick);
  return resting_.has_left(body, pose, speed_mps, constants_[body].reach_m);
}

void World::wake_on_those_that_left(const EventKey& event) {
  // The list grows by the bodies that wake; these are still in their places.
  for (std::size_t i = 0; i < changed_.size(); ++i) {
    const std::uint32_t body = changed_[i];
    if (is_resting(body) || !has_left(body, event.tick)) continue;
    note_contact_state(body);
    resting_.leave(body);
    wake_dependents(body, event);
  }
  std::sort(changed_.begin(), changed_.end());
}

void World::note_near_corners(std::uint32_t body, Tick tick) {
  Resting::Touches felt = resting_.touches(body, tick);
  for (std::size_t i = 0; i < felt.count; ++i) {
    const TouchRecord& touch = felt.records[i];
    const bool seen = std::any_of(
        felt.records.begin(), felt.records.begin() + i, [&](const TouchRecord& earlier) {
          return earlier.partner == touch.partner && earlier.feature == touch.feature &&
                 math::dot(earlier.normal, touch.normal) > k_same_face_cosine;
        });
    if (!seen) note_corners_like(body, touch, tick);
  }
}

/// All corners that touch, or nearly touch, the same face as a touch was at.
void World::note_corners_like(std::uint32_t body, const TouchRecord& touch, Tick tick) {
  const double near_m = k_near_corner * constants_[body].reach_m;
  const Vec3 centre_m = position_at(segments_[body].flight, tick);
  const auto note = [&](const Vec3& at_m, const Vec3& normal) {
    if (math::dot(normal, touch.normal) < k_same_face_cosine) return;
    TouchRecord near = touch;
    near.tick = tick;
    near.normal = normal;
    near.arm_m = at_m - centre_m;
    resting_.still_touches(body, near);
  };
  const auto note_both = [&](const MovingPiece& own, const MovingPiece& other) {
    corners_near(own, other, near_m, note);
    corners_near(other, own, near_m,
                 [&](const Vec3& at_m, const Vec3& normal) { note(at_m, -normal); });
  };
  for (std::uint32_t part = 0; part < constants_[body].part_count; ++part) {
    const MovingPiece own = part_at(body, part, tick);
    if (touch.partner != k_static_partner) {
      if (constants_[touch.partner].is_sphere) return;
      for (std::uint32_t other = 0; other < constants_[touch.partner].part_count; ++other)
        note_both(own, part_at(touch.partner, other, tick));
    } else if (is_surface(body, touch.feature)) {
      points_near(surface(touch.feature).surface, lattice_on(touch.feature, body, part), own,
                  near_m, note);
    } else if (touch.feature >= statics_.plane_count()) {
      note_both(own, statics_.piece(touch.feature));
    } else {
      const HalfSpace& solid = statics_.plane(touch.feature);
      for (std::size_t i = 0; i < own.view->vertex_count; ++i) {
        const Vec3 corner_m = to_world(own.pose, own.view->vertices_m[i]);
        if (math::dot(solid.normal, corner_m) - solid.offset_m <= near_m)
          note(corner_m, solid.normal);
      }
    }
  }
}

}  // namespace sleight::physics
