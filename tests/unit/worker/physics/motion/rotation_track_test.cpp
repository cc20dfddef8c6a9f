// Goal: a track's answers never depend on earlier queries. Method: query the same ticks in
// ascending, descending and random order. Also query them without a track. Compare the bits. Also
// test the horizon, up to which a rotation can be computed.
#include "worker/physics/motion/rotation_track.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/support/property.h"
#include "tests/unit/worker/physics/motion/support.h"

namespace sleight::physics {
namespace {

struct Answer {
  std::array<std::uint64_t, 4> orientation;
  std::array<std::uint64_t, 3> velocity;
  friend bool operator==(const Answer&, const Answer&) = default;
};

Answer cold(const FreeFlight& flight, const Inertia& inertia, Tick t) {
  return {bits_of(orientation_at(flight, inertia, t)),
          bits_of(angular_velocity_at(flight, inertia, t))};
}

Answer warm(RotationTrack& track, Tick t) {
  return {bits_of(track.orientation_at(t)), bits_of(track.angular_velocity_at(t))};
}

// Ticks in any order: far apart, slightly earlier than the previous tick (as in searches), and at
// the edges of steps.
std::vector<Tick> questions(random::Stream& stream, const FreeFlight& flight,
                            const Inertia& inertia) {
  const double span_s = 60 / math::norm(flight.angular_velocity_radps);
  const TickCount horizon = rotation_horizon(flight, inertia) - flight.begin;
  const TickCount step = std::max<TickCount>(1, horizon / GeneralRotation::k_steps_max);
  std::vector<Tick> ticks = {flight.begin, flight.begin + 1};
  for (int i = 0; i < 40; ++i) {
    const TickCount after = ticks_before(span_s * stream.uniform());
    ticks.push_back(flight.begin + after);
    ticks.push_back(flight.begin + after * 9 / 10);
    const TickCount edge = after / step * step;
    ticks.push_back(flight.begin + edge);
    if (edge > 0) ticks.push_back(flight.begin + (edge - 1));
    ticks.push_back(flight.begin + edge);
  }
  return ticks;
}

TEST(RotationTrack, answers_do_not_depend_on_the_order_of_questions) {
  for (const InertiaSymmetry symmetry : k_symmetries) {
    for (const std::uint64_t i : property::cases(property::of_tier(5, 15))) {
      random::Stream stream = stream_of(31, i);
      const Inertia inertia = random_inertia(stream, symmetry);
      const FreeFlight flight = random_flight(stream, std::fabs(of_any_size(stream, -2, 2)));
      std::vector<Tick> ticks = questions(stream, flight, inertia);
      RotationTrack any_order(flight, inertia);
      for (const Tick t : ticks)
        ASSERT_EQ(warm(any_order, t), cold(flight, inertia, t)) << i;
      RotationTrack in_order(flight, inertia);
      std::sort(ticks.begin(), ticks.end());
      for (const Tick t : ticks)
        ASSERT_EQ(warm(in_order, t), warm(any_order, t)) << i;
      // Query the ticks in descending order, with a track that followed another body before.
      RotationTrack reused(random_flight(stream, 50), random_inertia(stream, symmetry));
      reused.restart(flight, inertia);
      for (auto t = ticks.rbegin(); t != ticks.rend(); ++t)
        ASSERT_EQ(warm(reused, *t), warm(any_order, *t)) << i;
    }
  }
}

TEST(RotationTrack, begins_with_the_flights_own_bits) {
  for (const InertiaSymmetry symmetry : k_symmetries) {
    random::Stream stream = stream_of(33, 0);
    const Inertia inertia = random_inertia(stream, symmetry);
    const FreeFlight flight = random_flight(stream, 30);
    const Answer start{bits_of(flight.orientation), bits_of(flight.angular_velocity_radps)};
    EXPECT_EQ(cold(flight, inertia, flight.begin), start);
    RotationTrack track(flight, inertia);
    EXPECT_NE(warm(track, flight.begin + 1'000'000), start);
    EXPECT_EQ(warm(track, flight.begin), start);
  }
}

TEST(RotationHorizon, lies_past_any_sensible_flight_and_is_known_beforehand) {
  random::Stream stream = stream_of(35, 0);
  const Inertia inertia = random_inertia(stream, InertiaSymmetry::general);
  FreeFlight flight = random_flight(stream, 100);
  EXPECT_GT(seconds(rotation_horizon(flight, inertia) - flight.begin), 1'300);
  EXPECT_LT(rotation_horizon(flight, inertia), k_tick_max);
  flight.angular_velocity_radps = Vec3(1e-3, 0, 0);
  EXPECT_EQ(rotation_horizon(flight, inertia), k_tick_max);
  // The rotation is too fast for any step, so only the first tick is valid.
  flight.angular_velocity_radps = Vec3(1e9, 0, 0);
  EXPECT_EQ(rotation_horizon(flight, inertia), flight.begin);
  EXPECT_EQ(bits_of(orientation_at(flight, inertia, flight.begin)), bits_of(flight.orientation));
  // The closed form of a cube's rotation is valid at any speed.
  Inertia cube = random_inertia(stream, InertiaSymmetry::spherical);
  EXPECT_EQ(rotation_horizon(flight, cube), k_tick_max);
}

TEST(RotationHorizonDeathTest, questions_outside_the_flight_are_bugs) {
  random::Stream stream = stream_of(36, 0);
  const Inertia inertia = random_inertia(stream, InertiaSymmetry::general);
  const FreeFlight flight = random_flight(stream, 100);
  const Tick horizon = rotation_horizon(flight, inertia);
  EXPECT_DEATH(orientation_at(flight, inertia, horizon + 1), "check failed");
  EXPECT_DEATH(orientation_at(flight, inertia, flight.begin - 1), "check failed");
  FreeFlight broken = flight;
  broken.angular_velocity_radps[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_DEATH(RotationTrack(broken, inertia), "check failed");
}

}  // namespace
}  // namespace sleight::physics
