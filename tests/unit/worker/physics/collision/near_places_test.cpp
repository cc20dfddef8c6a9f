#include "worker/physics/collision/near_places.h"

#include <gtest/gtest.h>

#include "tests/support/property.h"
#include "tests/unit/worker/physics/motion/support.h"
#include "worker/physics/motion/rotation_track.h"

namespace sleight::physics {
namespace {

Vec3 random_direction(random::Stream& stream) {
  return math::normalized(vector_between(stream, -1, 1));
}

constexpr double k_reach_m = 0.02;
/// The room of a place: a hundredth of the reach, as in near_places.h.
constexpr double k_room_m = 0.01 * k_reach_m;

NearPlaces::Motion motion_of(const FreeFlight& flight, const Inertia& inertia) {
  return {.begin = flight.begin,
          .pose = {flight.position_m, flight.orientation},
          .speed_mps = math::norm(flight.velocity_mps) +
                       turning_speed_mps_max(rotation_bounds(flight, inertia), k_reach_m),
          .acceleration_mps2 = math::norm(flight.acceleration_mps2)};
}

/// Greatest distance that any of six points has moved. The points are k_reach_m from the body's
/// centre.
double moved_m(const Pose& then, const Pose& now) {
  double most_m = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-k_reach_m, k_reach_m}) {
      Vec3 point_m = Vec3::Zero();
      point_m[axis] = side;
      const Vec3 before_m = then.position_m + math::rotated(then.orientation, point_m);
      const Vec3 after_m = now.position_m + math::rotated(now.orientation, point_m);
      most_m = std::max(most_m, math::norm(after_m - before_m));
    }
  }
  return most_m;
}

TEST(NearPlaces, HoldWhatTheySay) {
  // Goal: while a body keeps its place, no point of the body moves further than the place's room
  // (near_places.h, invariant 1). Method: use bodies of every inertia symmetry. At random ticks,
  // change a body's slow motion to another slow motion. At random ticks of each motion, compute how
  // far six points of the body have moved.
  double nearest_to_bound = 0;
  std::uint64_t kept = 0;
  for (const std::uint64_t seed : property::cases(300)) {
    random::Stream stream = stream_of(51, seed);
    const auto symmetry = static_cast<InertiaSymmetry>(seed % 3);
    const Inertia inertia = random_inertia(stream, symmetry);
    NearPlaces places;
    places.reset(2, ticks_after(1e-4));
    places.began({1}, k_reach_m, {.stays = true});
    FreeFlight flight = random_flight(stream, 0.01);
    PlacesOfPair number = 0;
    Pose then;
    for (int jump = 0; jump < 60; ++jump) {
      const double speed_mps = 0.02 * stream.uniform();
      flight.velocity_mps = speed_mps * random_direction(stream);
      flight.acceleration_mps2 = {0, 0, stream.uniform() < 0.5 ? 0.0 : -9.81};
      const double turning_mps = 0.02 * stream.uniform();
      flight.angular_velocity_radps = turning_mps / k_reach_m * random_direction(stream);
      places.began({0}, k_reach_m, motion_of(flight, inertia));
      const PlacesOfPair present = places.of({0}, {1}, flight.begin);
      const Pose start{flight.position_m, flight.orientation};
      if (present != 0 && present == number) {
        ++kept;
      } else {
        then = start;
      }
      number = present;
      RotationTrack track(flight, inertia);
      if (present != 0) {
        const TickCount span = places.until(BodyId{0}, BodyId{1}) - flight.begin;
        for (int k = 0; k < 20; ++k) {
          const Tick tick =
              flight.begin + (k == 0 ? span : ticks_before(stream.uniform() * seconds(span)));
          ASSERT_EQ(places.of({0}, {1}, tick), present);
          const double way_m = moved_m(then, pose_at(flight, track, tick));
          ASSERT_LE(way_m, k_room_m) << seed;
          nearest_to_bound = std::max(nearest_to_bound, way_m / k_room_m);
        }
        EXPECT_EQ(places.of({0}, {1}, places.until(BodyId{0}, BodyId{1}) + 1), 0U);
      }
      const Tick next = flight.begin + 1 + ticks_before(3e-3 * stream.uniform());
      const Pose pose = pose_at(flight, track, next);
      flight.position_m = pose.position_m;
      flight.orientation = math::normalized(pose.orientation);
      flight.begin = next;
    }
  }
  if (!property::all_cases()) return;
  EXPECT_GT(nearest_to_bound, 0.9);
  EXPECT_GT(kept, 3000U);
}

TEST(NearPlaces, AFastBodyHasNone) {
  // Goal: a body gets no place if it would leave the place too soon, and no place number is used
  // twice. Method: let a body rest, then move fast, then move slowly.
  NearPlaces places;
  places.reset(2, ticks_after(1e-3));
  places.began({0}, k_reach_m, {.stays = true});
  places.began({1}, k_reach_m, {.stays = true});
  const PlacesOfPair first = places.of({0}, {1}, Tick{5});
  EXPECT_NE(first, 0U);
  EXPECT_EQ(places.until(BodyId{0}, BodyId{1}), k_never);
  places.began({1}, k_reach_m, {.begin = Tick{10}, .speed_mps = 1});
  EXPECT_EQ(places.of({0}, {1}, Tick{10}), 0U);
  places.began({1}, k_reach_m, {.begin = Tick{20}, .speed_mps = 0.01});
  EXPECT_NE(places.of({0}, {1}, Tick{20}), 0U);
  EXPECT_NE(places.of({0}, {1}, Tick{20}), first);
}

}  // namespace
}  // namespace sleight::physics
