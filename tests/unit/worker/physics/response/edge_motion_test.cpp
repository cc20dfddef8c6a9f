#include "worker/physics/response/edge_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/math/vector.h"
#include "common/random/stream.h"

namespace sleight::physics::edge_motion_test {

using math::cross;
using math::dot;
using math::norm;

constexpr double k_radius_m = 0.008;
constexpr double k_rise_m = 1e-5;
const Vec3 k_gravity_mps2(0, 0, -9.81);
const RoundBody k_ball{.radius_m = k_radius_m, .gyration = 0.4, .stick_mps = 1e-3};

/// A sphere on an edge through the origin.
struct Rider {
  Vec3 place_m = Vec3::Zero();
  Twist twist{};
};

Vec3 from_edge(const Vec3& d, const Vec3& place_m) {
  return place_m - dot(d, place_m) * d;
}

LastingContact contact_of(const Vec3& d, const Vec3& place_m, double friction) {
  return {.normal = math::normalized(from_edge(d, place_m)), .friction = friction};
}

double kinetic(const Twist& twist) {
  const Vec3& v = twist.velocity_mps;
  const Vec3& w = twist.angular_velocity_radps;
  return 0.5 * (dot(v, v) + k_ball.gyration * k_radius_m * k_radius_m * dot(w, w));
}
double energy(const Rider& rider) {
  return kinetic(rider.twist) - dot(k_gravity_mps2, rider.place_m);
}

std::optional<EdgePiece> piece_of(const Vec3& d, const Rider& rider, double friction, bool rolled,
                                  double rise_m = k_rise_m) {
  return edge_piece(k_ball, contact_of(d, rider.place_m, friction),
                    {.direction = d, .distance_m = norm(from_edge(d, rider.place_m))}, rider.twist,
                    rolled, k_gravity_mps2, rise_m);
}

Rider along(const EdgePiece& piece, const Rider& from, double s) {
  return {.place_m =
              from.place_m + s * piece.start.velocity_mps + (0.5 * s * s) * piece.acceleration_mps2,
          .twist = {.velocity_mps = piece.start.velocity_mps + s * piece.acceleration_mps2,
                    .angular_velocity_radps = piece.start.angular_velocity_radps +
                                              s * piece.angular_acceleration_radps2}};
}

/// A sphere on the edge, at `angle` from upright. The sphere moves around and along the edge, and
/// spins about the normal. The sphere rolls if `slip_mps` is zero.
Rider rider_at(const Vec3& d, double angle, double around_mps, double along_mps, double pivot_mps,
               const Vec3& slip_mps = Vec3::Zero()) {
  const Vec3 level = math::normalized(cross(d, Vec3(0, 0, 1)));
  const Vec3 up = cross(level, d);
  const Vec3 n = std::cos(angle) * up + std::sin(angle) * level;
  const Vec3 onwards = std::cos(angle) * level - std::sin(angle) * up;
  const Vec3 v = around_mps * onwards + along_mps * d;
  const Vec3 tangential = v - slip_mps + dot(slip_mps, n) * n;
  return {.place_m = k_radius_m * n,
          .twist = {
              .velocity_mps = v,
              .angular_velocity_radps = (1 / k_radius_m) * (pivot_mps * n + cross(n, tangential))}};
}

double uniform(random::Stream& stream, double low, double high) {
  return low + (high - low) * stream.uniform();
}

TEST(EdgePiece, RunsOutsideOfTheCylinderAndKeepsItsEnergy) {
  // Goal: on a piece of motion over an edge, a sphere doesn't sink, rises by at most the allowed
  // height and gains no energy (edge_motion.h). Method: for spheres that roll or slip, compute the
  // distance and the energy along random pieces. Exclude the energy with which the load lifts the
  // sphere.
  random::Stream stream({.seed = 7, .purpose = random::Purpose::scene}, 1);
  int pieces = 0;
  int rolling = 0;
  double worst_sink_m = 0;
  double worst_rise_m = 0;
  double worst_end_m = 0;
  double worst_gain = 0;
  double worst_change = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Vec3 d = math::normalized(
        Vec3(uniform(stream, -1, 1), uniform(stream, -1, 1), uniform(stream, -0.1, 0.1)));
    const bool slips = i % 2 == 0;
    const Vec3 slip_mps =
        slips ? Vec3(uniform(stream, -0.1, 0.1), uniform(stream, -0.1, 0.1), 0) : Vec3::Zero();
    const double angle = uniform(stream, -0.8, 0.8);
    const double around_mps = uniform(stream, -0.2, 0.2);
    const double along_mps = uniform(stream, -0.1, 0.1);
    const double pivot_mps = uniform(stream, -0.1, 0.1);
    const Rider start = rider_at(d, angle, around_mps, along_mps, pivot_mps, slip_mps);
    const auto piece = piece_of(d, start, 0.3, !slips);
    if (!piece) continue;
    ++pieces;
    const double distance_m = norm(from_edge(d, start.place_m));
    const Rider begin = along(*piece, start, 0);
    worst_gain = std::max(worst_gain, energy(begin) - energy(start));
    for (int part = 0; part <= 64; ++part) {
      Rider there = along(*piece, start, piece->lasts_s * part / 64);
      const double gap_m = norm(from_edge(d, there.place_m)) - distance_m;
      worst_sink_m = std::max(worst_sink_m, -gap_m);
      worst_rise_m = std::max(worst_rise_m, gap_m);
      if (part == 64) worst_end_m = std::max(worst_end_m, gap_m);
      there.twist = without_lift(k_ball,
                                 {.start = begin.twist,
                                  .acceleration_mps2 = piece->acceleration_mps2,
                                  .half_way = piece->half_way},
                                 k_gravity_mps2, there.place_m - start.place_m, there.twist);
      worst_gain = std::max(worst_gain, energy(there) - energy(begin));
      if (!piece->rolls || part < 64) continue;
      ++rolling;
      worst_change = std::max(
          worst_change, std::fabs(energy(along(*piece, start, piece->lasts_s)) - energy(begin)));
    }
  }
  std::printf(
      "%d pieces, %d roll: sink %.1e m, rise %.1e m, at the end %.1e m, gain %.1e J/kg, "
      "rolling changes it by %.1e\n",
      pieces, rolling, worst_sink_m, worst_rise_m, worst_end_m, worst_gain, worst_change);
  EXPECT_GT(pieces, 10'000);
  EXPECT_GT(rolling, 3'000);
  EXPECT_LT(worst_sink_m, 1e-16);
  EXPECT_LE(worst_rise_m, 1.0001 * k_rise_m);
  EXPECT_GT(worst_rise_m, 0.1 * k_rise_m);
  EXPECT_LT(worst_end_m, 1e-16);
  EXPECT_LT(worst_gain, 1e-15);
  EXPECT_LT(worst_change, 1e-15);
}

/// A sphere that rolls on an edge. Newton's and Euler's laws give v = w x R n and n' = v_across /
/// R. Friction at the contact gives k R^2 w' = -R n x (v' - g).
struct Rolling {
  Vec3 n = Vec3::Zero();
  Vec3 spin_radps = Vec3::Zero();
  double along_m = 0;
};
Rolling rate_of(const Vec3& d, const Rolling& state) {
  const Vec3 v = k_radius_m * cross(state.spin_radps, state.n);
  const Vec3 turn = (1 / k_radius_m) * (v - dot(d, v) * d);
  const Vec3 driven =
      (-1 / (k_ball.gyration * k_radius_m)) *
      cross(state.n, Vec3(k_radius_m * cross(state.spin_radps, turn) - k_gravity_mps2));
  return {.n = turn, .spin_radps = driven / (1 + 1 / k_ball.gyration), .along_m = dot(d, v)};
}
Rolling after(const Rolling& state, const Rolling& rate, double h) {
  return {.n = state.n + h * rate.n,
          .spin_radps = state.spin_radps + h * rate.spin_radps,
          .along_m = state.along_m + h * rate.along_m};
}
Rolling stepped(const Vec3& d, const Rolling& state, double h) {
  const Rolling a = rate_of(d, state);
  const Rolling b = rate_of(d, after(state, a, h / 2));
  const Rolling c = rate_of(d, after(state, b, h / 2));
  const Rolling e = rate_of(d, after(state, c, h));
  return after(after(after(after(state, a, h / 6), b, h / 3), c, h / 3), e, h / 6);
}

TEST(EdgePiece, FollowsASphereThatRolls) {
  // Goal: pieces of motion follow a sphere that rolls around and along an edge, even if the sphere
  // spins about the normal or turns back. A smaller allowed rise gives a smaller error. Method:
  // compare places with a Runge-Kutta integration of Newton's and Euler's equations in steps of a
  // microsecond. Stop when the sphere is 0.6 rad down a side.
  const Vec3 d = math::normalized(Vec3(1, 0.3, 0.02));
  struct Start {
    double angle, around_mps, along_mps, pivot_mps;
  };
  for (const Start& start : {Start{-0.3, 0.12, 0.03, 0.02}, Start{0.2, -0.05, 0.02, -0.04},
                             Start{0.05, 0.02, 0, 0}, Start{-0.2, 0.02, -0.05, 0.05}}) {
    double errors_m[2] = {};
    for (int finer = 0; finer < 2; ++finer) {
      const double rise_m = finer != 0 ? 1e-8 : 1e-6;
      Rider rider = rider_at(d, start.angle, start.around_mps, start.along_mps, start.pivot_mps);
      Rolling exact{.n = rider.place_m / k_radius_m,
                    .spin_radps = rider.twist.angular_velocity_radps};
      int pieces = 0;
      for (; pieces < 2'000; ++pieces) {
        const Vec3 n = math::normalized(from_edge(d, rider.place_m));
        if (n.z() < 0.8) break;
        const auto piece = piece_of(d, rider, 10, true, rise_m);
        ASSERT_TRUE(piece) << start.angle << " after " << pieces;
        ASSERT_TRUE(piece->rolls);
        const int steps = 1 + static_cast<int>(piece->lasts_s / 1e-6);
        for (int i = 0; i < steps; ++i)
          exact = stepped(d, exact, piece->lasts_s / steps);
        rider = along(*piece, rider, piece->lasts_s);
        const Vec3 there_m = k_radius_m * exact.n + exact.along_m * d;
        errors_m[finer] = std::max(errors_m[finer], norm(rider.place_m - there_m));
      }
      EXPECT_LT(pieces, 2'000);
      std::printf("from %+.2f rad at %+.3f m/s: %d pieces, off by %.1e m\n", start.angle,
                  start.around_mps, pieces, errors_m[finer]);
    }
    EXPECT_LT(errors_m[0], 5e-4);
    EXPECT_LT(errors_m[1], 0.1 * errors_m[0]);
  }
}

TEST(EdgePiece, ThereIsNoneForWhatFliesOrStands) {
  // Goal: if a sphere leaves the edge or doesn't move around the edge, edge_piece() returns
  // nothing. Method: test speeds above and below sqrt(g R). At this speed, an upright sphere leaves
  // the edge.
  const Vec3 d(0, 1, 0);
  const double leaves_mps = std::sqrt(9.81 * k_radius_m);
  EXPECT_FALSE(piece_of(d, rider_at(d, 0, 1.05 * leaves_mps, 0, 0), 0.5, true));
  EXPECT_TRUE(piece_of(d, rider_at(d, 0, 0.95 * leaves_mps, 0, 0), 0.5, true));
  EXPECT_FALSE(piece_of(d, rider_at(d, 0.3, 0, 0, 0), 0.5, true));
  EXPECT_FALSE(piece_of(d, rider_at(d, 0.3, 0, 0.1, 0), 0.5, true));
  EXPECT_FALSE(piece_of(d, rider_at(d, 2, 0.01, 0, 0), 0.5, true));
}

TEST(EdgePiece, FrictionMustSufficeForRolling) {
  // Goal: a rolling sphere begins to slip where a side is too steep for the friction. Method: test
  // friction above and below the limit. At the limit, mu N equals 2/7 of gravity along the side.
  const Vec3 d(1, 0, 0);
  const Rider rider = rider_at(d, 0.6, 0.05, 0, 0);
  const auto holds = piece_of(d, rider, 0.4, true);
  const auto slips = piece_of(d, rider, 0.15, true);
  ASSERT_TRUE(holds && slips);
  EXPECT_TRUE(holds->rolls);
  EXPECT_FALSE(slips->rolls);
}

}  // namespace sleight::physics::edge_motion_test
