// Goal: path boxes contain every evaluated position, at every tick and to the last bit, and are
// hardly larger than necessary. A sphere stays in a box up to exit_tick(), and hardly longer.
// Method: test random flights of all sizes at many ticks. Some ticks are around the apex. Compare
// exit ticks with roots in long double. Broken boxes must fail.
#include "worker/physics/motion/motion_bounds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "tests/support/property.h"
#include "tests/unit/worker/physics/motion/support.h"

namespace sleight::physics {
namespace {

// A motion on a parabola, evaluated with another order of operations.
struct OtherMotion {
  Tick begin;
  Vec3 position_m;
  Vec3 velocity_mps;
  Vec3 acceleration_mps2;
};
static_assert(OnParabola<OtherMotion>);

OtherMotion other(const FreeFlight& flight) {
  return {flight.begin, flight.position_m, flight.velocity_mps, flight.acceleration_mps2};
}

double coordinate(const FreeFlight& flight, int axis, Tick t) {
  return position_at(flight, t)[axis];
}

double coordinate(const OtherMotion& motion, int axis, Tick t) {
  const double s = seconds(t - motion.begin);
  return (motion.position_m[axis] + s * motion.velocity_mps[axis]) +
         (0.5 * s * s) * motion.acceleration_mps2[axis];
}

// Long double sums are exact enough to detect a box that is one bit too small.
template <class Motion>
bool holds(const Box& box, const Motion& motion, double radius_m, Tick t) {
  for (int axis = 0; axis < 3; ++axis) {
    const long double x = coordinate(motion, axis, t);
    const auto index = static_cast<std::size_t>(axis);
    if (x - radius_m < box.low_m[index] || x + radius_m > box.high_m[index]) return false;
  }
  return true;
}

FreeFlight flight_of_any_size(random::Stream& stream) {
  FreeFlight flight;
  flight.begin = Tick{static_cast<TickCount>(stream.bits() >> 24)};
  for (int axis = 0; axis < 3; ++axis) {
    flight.position_m[axis] = of_any_size(stream, -6, 6);
    flight.velocity_mps[axis] = of_any_size(stream, -15, 3);
    flight.acceleration_mps2[axis] = of_any_size(stream, -6, 1);
    const double kind = stream.uniform();
    if (kind < 0.2) flight.acceleration_mps2[axis] = 0;
    if (kind < 0.1) flight.velocity_mps[axis] = 0;
    // Choose the velocity so that the apex is within three seconds.
    if (kind > 0.6)
      flight.velocity_mps[axis] = -flight.acceleration_mps2[axis] * between(stream, 0, 3);
    if (kind > 0.95) flight.position_m[axis] = 0;
  }
  return flight;
}

// Ticks to test: both ends, the middle, random ticks, and ticks around the apex of each axis.
std::vector<Tick> ticks_to_look_at(random::Stream& stream, const FreeFlight& flight, Tick from,
                                   Tick to) {
  std::vector<Tick> ticks = {from, to, from + (to - from) / 2};
  for (int axis = 0; axis < 3; ++axis) {
    if (flight.acceleration_mps2[axis] == 0) continue;
    const Tick apex =
        flight.begin + ticks_before(-flight.velocity_mps[axis] / flight.acceleration_mps2[axis]);
    for (TickCount d = -3; d <= 3; ++d)
      if (apex + d >= from && apex + d <= to) ticks.push_back(apex + d);
  }
  for (int i = 0; i < 30; ++i)
    ticks.push_back(from +
                    static_cast<TickCount>(stream.uniform() * static_cast<double>(to - from)));
  return ticks;
}

Box without_apex(const FreeFlight& flight, double radius_m, Tick from, Tick to) {
  Box first = path_box(flight, radius_m, from, from);
  const Box last = path_box(flight, radius_m, to, to);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    first.low_m[axis] = std::min(first.low_m[axis], last.low_m[axis]);
    first.high_m[axis] = std::max(first.high_m[axis], last.high_m[axis]);
  }
  return first;
}

TEST(PathBox, holds_every_evaluated_position) {
  int apex_needed = 0;
  for (const std::uint64_t i : property::cases(30'000)) {
    random::Stream stream = stream_of(51, i);
    const FreeFlight flight = flight_of_any_size(stream);
    const double radius_m = i % 5 == 0 ? 0 : std::fabs(of_any_size(stream, -4, 2));
    const Tick from = flight.begin + ticks_before(std::fabs(of_any_size(stream, -9, 3)));
    const Tick to = from + ticks_before(std::fabs(of_any_size(stream, -9, 3)));
    const Box box = path_box(flight, radius_m, from, to);
    const Box other_box = path_box(other(flight), radius_m, from, to);
    EXPECT_EQ(box.low_m, other_box.low_m);
    const Box broken = without_apex(flight, radius_m, from, to);
    bool broken_holds = true;
    for (const Tick t : ticks_to_look_at(stream, flight, from, to)) {
      ASSERT_TRUE(holds(box, flight, radius_m, t)) << i;
      ASSERT_TRUE(holds(box, other(flight), radius_m, t)) << i;
      broken_holds = broken_holds && holds(broken, flight, radius_m, t);
    }
    if (!broken_holds) ++apex_needed;
  }
  if (!property::all_cases()) return;
  EXPECT_GT(apex_needed, 3'000);
}

// A flight up from far below. The apex is near height 0, where the distance between floats is far
// less than the rounding errors of evaluated heights.
FreeFlight flight_to_zero(random::Stream& stream) {
  FreeFlight flight;
  const double a = between(stream, 1, 20);
  const double v = between(stream, 100, 2'000);
  flight.acceleration_mps2 = Vec3(0, 0, -a);
  flight.velocity_mps = Vec3(0, 0, v);
  const double start = v * v / (2 * a);
  flight.position_m = Vec3(0, 0, -start * (1 + between(stream, -8, 8) * 0x1p-52));
  return flight;
}

Tick apex_of(const FreeFlight& flight) {
  return flight.begin + ticks_before(-flight.velocity_mps.z() / flight.acceleration_mps2.z());
}

TEST(PathBox, holds_the_rounding_of_heights_that_cancel) {
  // Evaluated heights near the apex have rounding errors in proportion to the start's height. If a
  // flight starts at the apex, path_box() returns a narrow box of two floats. Some heights are
  // outside this box.
  int noise_needed = 0;
  for (const std::uint64_t i : property::cases(300)) {
    random::Stream stream = stream_of(57, i);
    const FreeFlight flight = flight_to_zero(stream);
    const Tick apex = apex_of(flight);
    const Tick from = apex - 500;
    const Tick to = apex + 500;
    const Box box = path_box(flight, 0, from, to);
    FreeFlight at_apex;
    at_apex.position_m = position_at(flight, apex);
    const Box fine = path_box(at_apex, 0, Tick{}, Tick{});
    bool is_needed = false;
    for (Tick t = from; t <= to; t = t + 1) {
      ASSERT_TRUE(holds(box, flight, 0, t)) << i;
      ASSERT_TRUE(holds(box, other(flight), 0, t)) << i;
      is_needed = is_needed || position_at(flight, t).z() > fine.high_m[2];
    }
    if (is_needed) ++noise_needed;
  }
  if (!property::all_cases()) return;
  EXPECT_GT(noise_needed, 100);
}

TEST(ExitTick, a_lid_that_is_grazed_to_the_last_bit_is_not_passed_by) {
  int passed_by = 0;
  int met = 0;
  const Box box{.low_m = {-1, -1, -3e6F}, .high_m = {1, 1, 0}};
  for (const std::uint64_t i : property::cases(2'000)) {
    random::Stream stream = stream_of(58, i);
    FreeFlight flight = flight_to_zero(stream);
    // Lower the apex by up to 2^-43 of the box's width. The margin is proportional to this width.
    flight.position_m.z() -= between(stream, 0, 2) * 0x1p-44 * 3e6;
    const Tick apex = apex_of(flight);
    const Tick exit = exit_tick(box, flight, 0, flight.begin);
    ASSERT_GE(exit, flight.begin);
    ++(exit > apex ? passed_by : met);
    for (Tick t = apex - 300; t <= apex + 300 && t <= exit; t = t + 1) {
      ASSERT_TRUE(holds(box, flight, 0, t)) << i;
      ASSERT_TRUE(holds(box, other(flight), 0, t)) << i;
    }
  }
  if (!property::all_cases()) return;
  EXPECT_GT(passed_by, 300);
  EXPECT_GT(met, 300);
}

TEST(PathBox, is_at_most_two_floats_and_the_rounding_too_large) {
  for (const std::uint64_t i : property::cases(5'000)) {
    random::Stream stream = stream_of(53, i);
    const FreeFlight flight = flight_of_any_size(stream);
    const double radius_m = std::fabs(of_any_size(stream, -4, 2));
    const Tick from = flight.begin + ticks_before(between(stream, 0, 5));
    const Tick to = from + ticks_before(between(stream, 0, 5));
    const Box box = path_box(flight, radius_m, from, to);
    for (int axis = 0; axis < 3; ++axis) {
      const long double p = flight.position_m[axis];
      const long double v = flight.velocity_mps[axis];
      const long double a = flight.acceleration_mps2[axis];
      const auto at = [&](long double s) { return p + v * s + a * s * s / 2; };
      const long double s1 = seconds(from - flight.begin);
      const long double s2 = seconds(to - flight.begin);
      const long double apex = a != 0 ? std::clamp(-v / a, s1, s2) : s1;
      const long double low = std::min({at(s1), at(s2), at(apex)}) - radius_m;
      const long double high = std::max({at(s1), at(s2), at(apex)}) + radius_m;
      const long double rounding =
          0x1p-49L * (std::fabs(p) + std::fabs(v) * s2 + std::fabs(a) * s2 * s2 + radius_m);
      const auto index = static_cast<std::size_t>(axis);
      const float two_below =
          std::nextafter(std::nextafter(static_cast<float>(low - rounding), -INFINITY), -INFINITY);
      const float two_above =
          std::nextafter(std::nextafter(static_cast<float>(high + rounding), INFINITY), INFINITY);
      EXPECT_GE(box.low_m[index], two_below) << i;
      EXPECT_LE(box.high_m[index], two_above) << i;
    }
  }
}

// Reference: the least positive time, in long double, at which a coordinate reaches a wall.
long double first_meeting(long double distance, long double v, long double a) {
  // Solves distance = v s + a s^2/2 for s.
  constexpr long double k_none = std::numeric_limits<long double>::infinity();
  const auto positive = [](long double s) { return s > 0 ? s : k_none; };
  if (a == 0) return v == 0 ? k_none : positive(distance / v);
  const long double discriminant = v * v + 2 * a * distance;
  if (discriminant < 0) return k_none;
  const long double q = v >= 0 ? v + std::sqrt(discriminant) : v - std::sqrt(discriminant);
  return std::min(q != 0 ? positive(2 * distance / q) : k_none, positive(-q / a));
}

// Time for which the sphere stays between inner walls. The inner walls' distance from the box is
// twice the header's margin.
long double reference_stay_s(const Box& box, const FreeFlight& flight, double radius_m, Tick from) {
  const long double s = seconds(from - flight.begin);
  long double stay = std::numeric_limits<long double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const auto index = static_cast<std::size_t>(axis);
    const long double p0 = flight.position_m[axis];
    const long double a = flight.acceleration_mps2[axis];
    const long double v = static_cast<long double>(flight.velocity_mps[axis]) + a * s;
    const long double p = p0 + (flight.velocity_mps[axis] + a * s / 2) * s;
    const long double low = box.low_m[index];
    const long double high = box.high_m[index];
    const long double margin =
        2 * (0x1p-49L * (std::fabs(p0) + std::fabs(v) * s + 3 * std::fabs(a) * s * s + radius_m) +
             0x1p-44L * (high - low));
    const long double up = high - margin - radius_m - p;
    const long double down = p - (low + margin + radius_m);
    if (up <= 0 || down <= 0) return -1;
    stay = std::min({stay, first_meeting(up, v, a), first_meeting(-down, v, a)});
  }
  return stay;
}

TEST(ExitTick, the_sphere_stays_until_then_and_hardly_longer) {
  int inside = 0;
  int never = 0;
  for (const std::uint64_t i : property::cases(40'000)) {
    random::Stream stream = stream_of(55, i);
    const FreeFlight flight = flight_of_any_size(stream);
    const double radius_m = i % 7 == 0 ? 0 : std::fabs(of_any_size(stream, -4, 1));
    const Tick from = i % 2 == 0
                          ? flight.begin
                          : flight.begin + ticks_before(std::fabs(of_any_size(stream, -6, 2)));
    // A box around the start, sometimes hardly larger than the sphere.
    Box box = path_box(flight, radius_m, from, from);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.low_m[axis] -= static_cast<float>(std::fabs(of_any_size(stream, -6, 2)));
      box.high_m[axis] += static_cast<float>(std::fabs(of_any_size(stream, -6, 2)));
    }
    const Tick exit = exit_tick(box, flight, radius_m, from);
    ASSERT_GE(exit, from - 1);
    ASSERT_LE(exit, k_tick_max);
    if (exit == k_tick_max) ++never;
    if (exit >= from) {
      ++inside;
      for (const Tick t : ticks_to_look_at(stream, flight, from, exit)) {
        ASSERT_TRUE(holds(box, flight, radius_m, t)) << i;
        ASSERT_TRUE(holds(box, other(flight), radius_m, t)) << i;
      }
    }
    const long double stay = reference_stay_s(box, flight, radius_m, from);
    const long double earliest = stay * (1 - 0x1p-39L) * 0x1p30L - 1;
    const auto ticks = static_cast<long double>(exit - from);
    ASSERT_TRUE(exit == k_tick_max || ticks >= earliest)
        << i << ' ' << exit - from << ' ' << static_cast<double>(earliest);
  }
  if (!property::all_cases()) return;
  EXPECT_GT(inside, 35'000);
  EXPECT_GT(never, 50);
}

TEST(ExitTick, what_never_moves_never_leaves_and_what_is_outside_is_told) {
  FreeFlight flight;
  flight.begin = Tick{1'000};
  const Box box{.low_m = {-1, -1, -1}, .high_m = {1, 1, 1}};
  EXPECT_EQ(exit_tick(box, flight, 0.5, Tick{2'000}), k_tick_max);
  EXPECT_EQ(exit_tick(box, flight, 1, Tick{2'000}), Tick{1'999});
  flight.position_m = Vec3(0, 3, 0);
  EXPECT_EQ(exit_tick(box, flight, 0.5, Tick{2'000}), Tick{1'999});
  // The motion is so slow that squares underflow.
  flight.position_m = Vec3(0, 0, 0);
  flight.velocity_mps = Vec3(1e-200, 0, 0);
  flight.acceleration_mps2 = Vec3(0, -1e-250, 0);
  EXPECT_EQ(exit_tick(box, flight, 0.5, Tick{2'000}), k_tick_max);
}

TEST(CentreSpeed, bounds_the_speed_between_two_ticks) {
  for (const std::uint64_t i : property::cases(2'000)) {
    random::Stream stream = stream_of(56, i);
    const FreeFlight flight = flight_of_any_size(stream);
    const Tick from = flight.begin + ticks_before(between(stream, 0, 5));
    const Tick to = from + ticks_before(between(stream, 0, 5));
    const double bound = centre_speed_mps_max(flight, from, to);
    double greatest = 0;
    for (const Tick t : ticks_to_look_at(stream, flight, from, to))
      greatest = std::max(greatest, math::norm(velocity_at(flight, t)));
    EXPECT_LE(greatest, bound);
    EXPECT_GE(greatest * (1 + 1e-8), bound);
  }
}

}  // namespace
}  // namespace sleight::physics
