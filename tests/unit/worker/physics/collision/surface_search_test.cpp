// Compares the search for boxes above spline surfaces with a reference, which tests every lattice
// point of a box.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "tests/support/property.h"
#include "tests/unit/worker/physics/collision/surface_meeting.h"
#include "tests/unit/worker/physics/collision/surface_tables.h"
#include "worker/physics/collision/surface_search.h"

namespace sleight::physics {
namespace {

using testing::AllPoints;
using testing::Dice;
using testing::Flyer;
using testing::Meeting;
using testing::Relief;
using testing::same_contact;

constexpr std::uint64_t k_seed = 20261122;

StaticSurface random_surface(Dice& dice) {
  const auto relief = static_cast<Relief>(dice.below(testing::k_reliefs));
  const double height_m = dice.between(1e-4, 5e-3);
  const double spacing_m = dice.between(5e-3, 40e-3);
  return testing::table_surface(testing::random_table(dice.below(1'000'000), relief, height_m),
                                spacing_m, dice.one_in(3) ? 1.5e-3 : 4e-3);
}

BodyShape random_body(Dice& dice) {
  const double side_m = dice.between(5e-3, 30e-3);
  if (dice.below(4) != 0) return testing::die_of(side_m);
  return testing::solid_of(
      box(Vec3(side_m, side_m * dice.between(0.5, 2), side_m * dice.between(0.5, 2))).value(),
      InertiaSymmetry::general);
}

/// Places the box near the surface: nearly flat, on an edge, on a corner, or in any orientation.
/// The box touches the surface, is slightly inside it, or is up to a centimetre above it.
void place(Meeting& meeting, Dice& dice) {
  FreeFlight& flight = meeting.flyer().flight;
  flight.position_m = {dice.within(0.3), dice.within(0.3), 0.02};
  const SurfacePlace below = meeting.surface().at(flight.position_m.x(), flight.position_m.y());
  constexpr double k_eighth = 0.785398163397448;
  Vec3 tilt = Vec3::Zero();
  const auto kind = dice.below(4);
  if (kind == 1) tilt.x() = k_eighth;
  if (kind == 2) tilt = {k_eighth, 0.6154797086703873, 0};
  Quat turn = math::quaternion_of_rotation_vector(tilt);
  if (kind == 3) turn = testing::random_turn(dice);
  const Quat about_z = math::quaternion_of_rotation_vector({0, 0, dice.within(3)});
  const Quat along_table =
      math::quaternion_of_rotation_vector({std::atan(below.slope_y), -std::atan(below.slope_x), 0});
  const Quat a_bit =
      math::quaternion_of_rotation_vector(dice.vector_within(dice.between(1e-9, 0.3)));
  flight.orientation = math::normalized(
      math::composed(a_bit, math::composed(along_table, math::composed(about_z, turn))));
  const std::array<double, 6> gaps_m{-1e-9,
                                     0.5 * k_touch_m,
                                     k_touch_m,
                                     k_touch_m * (1 + 1e-9),
                                     1e-6 * dice.between(0.1, 100),
                                     dice.between(1e-5, 1e-2)};
  meeting.lower_to(gaps_m[dice.below(gaps_m.size())]);
}

/// Lets the box fly, fall, slide, or turn about its lowest point.
void move(Meeting& meeting, Dice& dice) {
  FreeFlight& flight = meeting.flyer().flight;
  flight.acceleration_mps2 = {0, 0, dice.one_in(8) ? 0 : -9.81};
  if (dice.one_in(8)) flight.acceleration_mps2 += dice.vector_within(5);
  flight.angular_velocity_radps = dice.vector_within(dice.between(1e-3, 100));
  flight.velocity_mps = dice.vector_within(dice.between(1e-6, 3));
  if (dice.one_in(8)) flight.angular_velocity_radps = Vec3::Zero();
  if (dice.one_in(8)) flight.velocity_mps = Vec3(0, 0, flight.velocity_mps.z());
  if (dice.one_in(2)) {
    const MovingPiece box = meeting.at(flight.begin);
    const Vec3 arm_m = meeting.contact_at(flight.begin).point_m - flight.position_m;
    flight.velocity_mps = -math::cross(box.angular_velocity_radps, arm_m) +
                          dice.vector_within(dice.between(1e-9, 0.1));
  }
}

struct Tally {
  std::uint64_t looks = 0;
  std::uint64_t collisions = 0;
  std::uint64_t compared = 0;  ///< ticks at which all points were examined
};

/// Expects that no point collides at ticks between one look and the next.
void expect_none_between(Meeting& meeting, Tick from, Tick next, Dice& dice, Tally& tally) {
  const auto look = [&](Tick tick) {
    if (tick <= from || tick >= next) return;
    ++tally.compared;
    const AllPoints all = meeting.all_at(tick);
    ASSERT_FALSE(all.collides) << fmt::format("from {}, next {}, but at {}: gap {} m, rate {} m/s",
                                              from.value, next.value, tick.value, all.contact.gap_m,
                                              all.contact.rate_mps);
  };
  const TickCount span = next - from;
  for (const TickCount before : {1, 2, 3, 10})
    look(next - before);
  for (int i = 0; i < 2; ++i)
    look(from + static_cast<TickCount>(dice.below(static_cast<std::uint64_t>(span))));
  for (TickCount before = 32; before < span; before *= 32)
    look(next - before);
  if (span <= 1 || !dice.one_in(8)) return;
  for (int i = 1; i < 32; ++i)
    look(from + std::max<TickCount>(1, span / 32) * i);
}

/// Runs a search as a simulation does. Returns the tick of the collision, or nothing if the box
/// doesn't collide before `end`. If `near` is null, each look starts from scratch.
std::optional<Tick> walk(Meeting& meeting, Tick end, NearPoints* near, Dice& dice, Tally& tally) {
  Tick tick = meeting.flyer().flight.begin;
  if (near != nullptr) near->forget_motion();
  for (int looks = 0; tick < end; ++looks) {
    if (looks >= 3000) return tick;  // the box turns about a touching point: enough ticks seen
    ++tally.looks;
    NearPoints fresh;
    PieceContact contact;
    const Examined examined = meeting.examine(tick, near != nullptr ? *near : fresh, contact);
    const AllPoints all = meeting.all_at(tick);
    EXPECT_EQ(examined.collides, all.collides) << tick.value;
    if (examined.collides != all.collides) return std::nullopt;
    if (examined.collides) {
      EXPECT_TRUE(same_contact(contact, all.contact));
      EXPECT_TRUE(same_contact(contact, meeting.contact_at(tick)));
      return tick;
    }
    if (dice.one_in(4)) {
      EXPECT_EQ(meeting.contact_at(tick).gap_m, all.least_m);
      NearPoints other;
      PieceContact none;
      const Examined again = meeting.examine(tick, other, none);
      EXPECT_FALSE(again.collides);
      expect_none_between(meeting, tick, std::min(again.next, end), dice, tally);
    }
    EXPECT_GT(examined.next, tick);
    expect_none_between(meeting, tick, std::min(examined.next, end), dice, tally);
    if (::testing::Test::HasFailure()) return std::nullopt;
    tick = examined.next;
  }
  return std::nullopt;
}

/// Imitates an impact: the box leaves the surface or moves on slowly.
void bounce(Meeting& meeting, Tick tick, Dice& dice) {
  const MovingPiece box = meeting.at(tick);
  const PieceContact contact = meeting.contact_at(tick);
  FreeFlight& flight = meeting.flyer().flight;
  const Vec3 arm_m = contact.point_m - box.pose.position_m;
  flight.orientation = math::normalized(orientation_at(flight, meeting.flyer().body.inertia, tick));
  flight.begin = tick;
  flight.position_m = box.pose.position_m;
  flight.angular_velocity_radps =
      box.angular_velocity_radps + dice.vector_within(dice.between(1e-3, 10));
  const Vec3 point_mps = box.velocity_mps + math::cross(flight.angular_velocity_radps, arm_m);
  const double away_mps = dice.one_in(3) ? 1e-9 : dice.between(1e-6, 0.3);
  flight.velocity_mps =
      box.velocity_mps + (away_mps - math::dot(point_mps, contact.normal)) * contact.normal;
}

TEST(SurfaceSearch, SkipsNoCollisionAndKeepsNothingThatMatters) {
  // Goal: a look finds the right verdict and contact, and the search skips no collision
  // (surface_search.h, invariants 1 and 2). Method: let random boxes fly, fall, slide, turn and
  // bounce close to random surfaces. At each look, compare the verdict and the contact with a test
  // of all points. Compare some verdicts with a new search's verdicts. Compare all contacts with
  // contact_of(). At some skipped ticks, test all points.
  Tally tally;
  const std::uint64_t count = property::long_run() ? 10'000 : property::of_tier(140, 700);
  for (const std::uint64_t n : property::cases(count)) {
    if (HasFailure()) break;
    Dice dice(k_seed, n);
    const StaticSurface surface = random_surface(dice);
    Flyer flyer{random_body(dice), {}};
    flyer.flight.begin = Tick{1'000'000};
    Meeting meeting(surface, flyer);
    place(meeting, dice);
    move(meeting, dice);
    NearPoints near;
    for (int bounces = 0; bounces < 4 && !HasFailure(); ++bounces) {
      const Tick end = flyer.flight.begin + ticks_after(0.03);
      const std::optional<Tick> met = walk(meeting, end, &near, dice, tally);
      if (dice.one_in(2)) {
        const std::optional<Tick> again = walk(meeting, end, nullptr, dice, tally);
        const bool both_end = met && again && meeting.all_at(*met).collides;
        if (both_end && meeting.all_at(*again).collides) {
          EXPECT_EQ(*again, *met);
        }
      }
      if (!met || HasFailure()) break;
      ++tally.collisions;
      bounce(meeting, *met, dice);
    }
  }
  fmt::print("{} looks, {} collisions, all points at {} skipped ticks\n", tally.looks,
             tally.collisions, tally.compared);
  if (property::all_cases()) {
    EXPECT_GT(tally.collisions, count / 2);
  }
}

/// Heights are constant along y. Along x, they have the given second derivative at the control
/// points.
std::shared_ptr<const testing::TableControls> profile(std::function<double(int)> bend_per_m,
                                                      double spacing_m) {
  return testing::table_of([bend_per_m = std::move(bend_per_m), spacing_m](GridIndex index) {
    // The spline's second derivative is a combination of second differences of control points.
    double height_m = 0;
    double slope_m = 0;
    for (int i = 1; i <= index.i; ++i) {
      slope_m += bend_per_m(i - 1) * spacing_m * spacing_m;
      height_m += slope_m;
    }
    return SurfaceControl{.height_m = height_m, .restitution = 0.5, .friction = 0.5};
  });
}

TEST(SurfaceSearch, WhatRisesFromAHollowMayComeBack) {
  // Goal: the search's bounds hold even if a box's lowest corner is in a hollow, but the box first
  // touches a gentle hill beside the hollow. Method: drop boxes that have one corner above a
  // hollow. The hollow's curvature is several times the hill's curvature. Tilt each box by the
  // angle that is about half of the box's side times the hill's curvature.
  Tally tally;
  for (const std::uint64_t n : property::cases(1500)) {
    if (HasFailure()) break;
    Dice dice(k_seed + 1, n);
    const double spacing_m = 5e-3;
    const double hill_per_m = dice.between(0.5, 4);
    const double hollow_per_m = hill_per_m * dice.between(2, 10);
    const auto bend_per_m = [=](int i) {
      if (i < 0 || i > 9) return 0.0;
      return i <= 1 ? (1 - i) * hollow_per_m : -hill_per_m;
    };
    const double side_m = 0.025 + dice.within(0.005);
    Flyer flyer{testing::die_of(side_m), {}};
    flyer.flight.begin = Tick{1'000'000};
    Meeting meeting(testing::table_surface(profile(bend_per_m, spacing_m), spacing_m), flyer);
    const double half = 0.5 * hill_per_m * side_m;
    const double rise = half * (1 + dice.within(0.5));
    flyer.flight.orientation = math::normalized(
        math::composed(math::quaternion_of_rotation_vector({0, -rise, 0}),
                       math::quaternion_of_rotation_vector({half * (1.5 + dice.within(1)), 0, 0})));
    flyer.flight.position_m = {0.5 * side_m + dice.within(3e-3), dice.within(0.01), 0.1};
    meeting.lower_to(dice.between(1e-7, 1e-4));
    flyer.flight.velocity_mps = {0, 0, -dice.between(1e-3, 1)};
    flyer.flight.acceleration_mps2 = {0, 0, -9.81};
    flyer.flight.angular_velocity_radps = dice.vector_within(dice.between(1e-6, 1e-3));
    NearPoints near;
    const Tick end = flyer.flight.begin + ticks_after(0.02);
    const auto met = walk(meeting, end, &near, dice, tally);
    EXPECT_TRUE(met);
  }
}

TEST(SurfaceSearch, BoundsAreOfWhereBoxesCome) {
  // Goal: the search's bounds hold for the part of the surface that a box will reach. The part that
  // a box will reach can be steeper and more curved than the part now below the box. Method: let
  // boxes slide and roll fast, just above a flat table, towards steps and ridges.
  Tally tally;
  for (const std::uint64_t n : property::cases(160)) {
    if (HasFailure()) break;
    Dice dice(k_seed + 4, n);
    const double spacing_m = dice.between(2e-3, 8e-3);
    const double high_m = dice.between(1e-4, 6e-3) * (dice.one_in(4) ? -1 : 1);
    const auto first = static_cast<std::int32_t>(5 + dice.below(12));
    const std::int32_t last = dice.one_in(2) ? 1000 : first;
    auto table = testing::table_of([=](GridIndex index) {
      return SurfaceControl{.height_m = index.i >= first && index.i <= last ? high_m : 0};
    });
    Flyer flyer{testing::die_of(dice.between(5e-3, 2e-2)), {}};
    flyer.flight.begin = Tick{1'000'000};
    Meeting meeting(testing::table_surface(table, spacing_m, dice.one_in(2) ? 2e-3 : 4e-3), flyer);
    place(meeting, dice);
    flyer.flight.position_m.x() = -dice.between(1e-3, 3e-2);
    meeting.lower_to(dice.between(1e-7, 1e-3));
    const double way_m = first * spacing_m;
    flyer.flight.velocity_mps = {dice.between(0.2, 5), dice.within(0.1), dice.within(0.01)};
    flyer.flight.angular_velocity_radps =
        dice.vector_within(dice.one_in(2) ? 1e-3 : dice.between(1, 100));
    flyer.flight.acceleration_mps2 = {0, 0, dice.one_in(2) ? 0 : -9.81};
    if (dice.one_in(4)) flyer.flight.acceleration_mps2.x() = 30;
    NearPoints near;
    for (int bounces = 0; bounces < 4 && !HasFailure(); ++bounces) {
      const double time_s = 2 * way_m / flyer.flight.velocity_mps.x();
      const Tick end = flyer.flight.begin + ticks_after(std::clamp(time_s, 0.001, 0.05));
      const auto met = walk(meeting, end, dice.one_in(4) ? nullptr : &near, dice, tally);
      if (!met) break;
      ++tally.collisions;
      const Vec3 velocity_mps = flyer.flight.velocity_mps;
      bounce(meeting, *met, dice);
      flyer.flight.velocity_mps.x() = velocity_mps.x();
    }
  }
  if (!property::all_cases()) return;
  EXPECT_GT(tally.collisions, 60U);
}

TEST(SurfaceSearch, StillBoxesAreNotWalkedBy) {
  // Goal: if a box neither rotates nor moves sideways, the bounds hold forever, and no product of
  // zero and infinity becomes NaN. Method: let boxes rise, hover or fall above a flat table and a
  // rough table, with gravity and without it. Fewer than 300 looks must suffice for each box.
  for (const Relief relief : {Relief::flat, Relief::rough}) {
    for (const double up_mps : {0.0, 1e-3, 0.5, -0.5}) {
      for (const double pull_mps2 : {0.0, -9.81}) {
        SCOPED_TRACE(fmt::format("relief {}, {} m/s, {} m/s^2", static_cast<int>(relief), up_mps,
                                 pull_mps2));
        Dice dice(k_seed, 7);
        Tally tally;
        Flyer flyer{testing::die_of(0.016), {}};
        Meeting meeting(testing::table_surface(testing::random_table(3, relief, 2e-3), 0.01),
                        flyer);
        flyer.flight.position_m.z() = 0.05;
        meeting.lower_to(1e-3);
        flyer.flight.velocity_mps = {0, 0, up_mps};
        flyer.flight.acceleration_mps2 = {0, 0, pull_mps2};
        NearPoints near;
        const auto met = walk(meeting, Tick{} + ticks_after(1), &near, dice, tally);
        EXPECT_EQ(met.has_value(), up_mps < 0 || pull_mps2 < 0);
        EXPECT_LT(tally.looks, 300U);
      }
    }
  }
}

TEST(SurfaceSearch, OfEqualGapsTheFirstOneCounts) {
  // Goal: if several points have the same least gap, the contact is the first of these points in
  // lattice order (surface_search.h, invariant 1). The order in which the search stores near points
  // doesn't matter. Method: rotate a die that is flat above a flat table, so that its sides
  // approach at different speeds. Then let the die touch the table and move straight down without
  // rotation.
  for (const Vec3& turning : {Vec3(5, 0, 0), Vec3(-5, 0, 0), Vec3(0, 5, 0), Vec3(0, -5, 0)}) {
    Flyer flyer{testing::die_of(0.016), {}};
    flyer.flight.begin = Tick{1'000'000};
    Meeting meeting(testing::table_surface(testing::random_table(1, Relief::flat, 0), 0.01), flyer);
    flyer.flight.position_m.z() = 0.1;
    meeting.lower_to(2e-6);
    flyer.flight.velocity_mps = {0, 0, -0.02};
    flyer.flight.angular_velocity_radps = turning;
    NearPoints near;
    PieceContact contact;
    EXPECT_FALSE(meeting.examine(flyer.flight.begin, near, contact).collides);
    EXPECT_TRUE(near.known);
    EXPECT_FALSE(std::ranges::is_sorted(std::span(near.order).first(near.count)));
    meeting.lower_to(0.5 * k_touch_m);
    flyer.flight.angular_velocity_radps = Vec3::Zero();
    near.forget_motion();
    EXPECT_TRUE(meeting.examine(flyer.flight.begin, near, contact).collides);
    EXPECT_TRUE(same_contact(contact, meeting.all_at(flyer.flight.begin).contact));
  }
}

TEST(SurfaceSearch, BoxesHaveLattices) {
  // Goal: neighbouring lattice points are at most the spacing apart, even if a side is a whole
  // multiple of the spacing. Adjacent faces share the points of their common edge. Solids other
  // than boxes have no lattice.
  Dice dice(k_seed, 9);
  for (int n = 0; n < 400; ++n) {
    const double spacing_m = dice.between(5e-4, 5e-3);
    Vec3 sides_m;
    for (int axis = 0; axis < 3; ++axis)
      sides_m[axis] = n % 2 == 0 ? dice.between(2e-3, 5e-2)
                                 : spacing_m * static_cast<double>(1 + dice.below(20));
    const BodyShape solid = testing::solid_of(box(sides_m).value(), InertiaSymmetry::general);
    const ConvexView view = solid.parts[0].view();
    const auto lattice = BoxLattice::of(view, spacing_m);
    ASSERT_TRUE(lattice);
    std::int32_t most = 0;
    const auto at = [&](std::size_t vertex) { return view.vertices_m[vertex]; };
    const auto check = [&](std::size_t a, std::size_t b, std::int32_t steps) {
      const double length_m = math::norm(at(b) - at(a));
      EXPECT_LE(length_m / steps, spacing_m * (1 + 1e-6));
      EXPECT_GT(length_m / (steps - 1), spacing_m);
      most = std::max(most, steps);
      for (const EdgeLattice& edge : lattice->edges) {
        const bool same =
            (edge.end[0] == a && edge.end[1] == b) || (edge.end[0] == b && edge.end[1] == a);
        if (same) {
          EXPECT_EQ(edge.steps, steps) << length_m << " in steps of " << spacing_m;
        }
      }
    };
    std::array<int, 8> seen{};
    for (const FaceLattice& face : lattice->faces) {
      check(face.corner[0], face.corner[1], face.along);
      check(face.corner[3], face.corner[2], face.along);
      check(face.corner[0], face.corner[3], face.across);
      check(face.corner[1], face.corner[2], face.across);
      for (const std::uint16_t corner : face.corner)
        ++seen[corner];
    }
    for (const int faces : seen)
      EXPECT_EQ(faces, 3);
    EXPECT_EQ(lattice->steps_most, most);
  }
  const auto refused = [](const ConvexPolyhedron& solid, double spacing_m) {
    return !BoxLattice::of(solid.view(), spacing_m);
  };
  EXPECT_TRUE(refused(tetrahedron(0.01).value(), 4e-3));
  EXPECT_TRUE(refused(icosphere(0.01, 1).value(), 4e-3));
  EXPECT_TRUE(refused(regular_prism(6, 0.01, 0.01).value(), 4e-3));
  EXPECT_FALSE(refused(regular_prism(4, 0.01, 0.02).value(), 4e-3));
  // A frustum has six quadrilaterals but is no box.
  std::vector<Vec3> frustum_m;
  for (const double high : {0.0, 1.0}) {
    for (const double x : {-1.0, 1.0}) {
      for (const double y : {-1.0, 1.0})
        frustum_m.push_back(0.01 * Vec3((2 - high) * x, (2 - high) * y, high));
    }
  }
  EXPECT_TRUE(refused(convex_hull(frustum_m).value(), 4e-3));
  EXPECT_FALSE(refused(cube(0.01).value(), 0.01 / BoxLattice::k_steps_max));
  EXPECT_TRUE(refused(cube(0.01).value(), 0.0099 / BoxLattice::k_steps_max));
}

TEST(SurfaceSearch, PointsNearAreTheOutermostOnes) {
  // Goal: among a box's points that are near the surface, points_near() finds the outermost.
  // Method: put boxes close to random surfaces. Each point found must be within reach of the
  // surface and have the surface's normal. In each of eight directions, one of the points found
  // must be the outermost of all points within reach.
  std::size_t found_in_all = 0;
  for (const std::uint64_t n : property::cases(300)) {
    Dice dice(k_seed + 3, n);
    const StaticSurface surface = random_surface(dice);
    Flyer flyer{random_body(dice), {}};
    Meeting meeting(surface, flyer);
    place(meeting, dice);
    const MovingPiece box = meeting.at(Tick{});
    const double near_m = dice.between(1e-7, 1e-3);
    std::vector<Vec3> found_m;
    points_near(meeting.surface(), meeting.lattice(), box, near_m,
                [&](const Vec3& at_m, const Vec3& normal) {
                  found_m.push_back(at_m);
                  const SurfacePlace below = meeting.surface().at(at_m.x(), at_m.y());
                  EXPECT_LE(at_m.z() - below.height_m, near_m);
                  EXPECT_EQ(normal, math::normalized(Vec3(-below.slope_x, -below.slope_y, 1)));
                });
    EXPECT_LE(found_m.size(), k_surface_points_max);
    found_in_all += found_m.size();
    for (int k = 0; k < 8; ++k) {
      const Vec3 way(std::cos(0.785398163397448 * k), std::sin(0.785398163397448 * k), 0);
      double furthest_m = -1;
      for (const Vec3& own_m : meeting.own_m()) {
        const Vec3 place_m = to_world(box.pose, own_m);
        const double gap_m = place_m.z() - meeting.surface().at(place_m.x(), place_m.y()).height_m;
        if (gap_m <= near_m)
          furthest_m = std::max(furthest_m, math::dot(way, place_m - box.pose.position_m));
      }
      double found = -1;
      for (const Vec3& at_m : found_m)
        found = std::max(found, math::dot(way, at_m - box.pose.position_m));
      EXPECT_NEAR(found, furthest_m, 1e-12);
    }
  }
  if (!property::all_cases()) return;
  EXPECT_GT(found_in_all, 100U);
}

}  // namespace
}  // namespace sleight::physics
