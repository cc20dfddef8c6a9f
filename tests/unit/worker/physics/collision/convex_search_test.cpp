// Compares convex_search with contacts computed from scratch at skipped ticks.
#include "worker/physics/collision/convex_search.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "tests/support/property.h"
#include "tests/unit/worker/physics/collision/flyer.h"
#include "tests/unit/worker/physics/collision/surface_tables.h"
#include "worker/physics/collision/first_collision.h"
#include "worker/physics/shape/shapes.h"
#include "worker/physics/shape/small_pieces.h"

namespace sleight::physics::convex_search_test {

using testing::Dice;
using testing::Flyer;

constexpr std::uint64_t k_seed = 1;

Vec3 direction(Dice& dice) {
  return math::normalized(dice.vector_within(1));
}

enum class Solid : std::uint8_t { die, tetrahedron, prism, slab };

BodyShape body_of(Solid solid, double size_m) {
  switch (solid) {
    case Solid::die:
      return testing::die_of(size_m);
    case Solid::tetrahedron:
      return testing::solid_of(tetrahedron(size_m).value(), InertiaSymmetry::spherical);
    case Solid::prism:
      return testing::solid_of(regular_prism(5, size_m, 2 * size_m).value(),
                               InertiaSymmetry::axial);
    case Solid::slab:
      break;
  }
  return testing::solid_of(box(Vec3(size_m, 1.5 * size_m, 0.4 * size_m)).value(),
                           InertiaSymmetry::general);
}

BodyShape random_body(Dice& dice) {
  const double size_m = dice.between(5e-3, 0.1);
  return body_of(static_cast<Solid>(dice.below(4)), size_m);
}

/// A flying body that approaches a flying body, a body at rest, a sphere or a plane.
class Approach {
 public:
  enum class Other : std::uint8_t { flies, stays, sphere, plane };

  explicit Approach(Dice& dice)
      : touch_m(dice.one_in(4) ? 3e-8 : k_touch_m),
        other_(static_cast<Other>(dice.below(4))),
        first_{random_body(dice), {}},
        second_{random_body(dice), {}},
        first_view_(first_.part().view()),
        second_view_(second_.part().view()) {
    // Bodies meet far from the origin or after a long flight: both cause rounding in positions.
    const Vec3 about_m = dice.between(1e-2, 100) * direction(dice);
    const bool both_fly = other_ == Other::flies || other_ == Other::sphere;
    const Vec3 common_mps = both_fly ? Vec3(dice.between(1e-3, 10) * direction(dice)) : zero();
    const Vec3 pull_mps2 = dice.one_in(3) ? zero() : Vec3(0, 0, -9.81);
    const bool evenly = first_.body.inertia.symmetry != InertiaSymmetry::general &&
                        second_.body.inertia.symmetry != InertiaSymmetry::general;
    const Tick began{static_cast<TickCount>(dice.below(std::uint64_t{1} << 30U))};
    begin = began + ticks_after(dice.between(1e-3, evenly ? 10 : 1e-2));
    // Hovering bodies are slower than the least speed that counts as an approach.
    const bool hovers = dice.one_in(10);
    const bool parts = dice.one_in(4);
    const double speed_mps = (parts ? -1 : 1) * (hovers ? 1e-10 : dice.between(1e-6, 3));
    const double after_s = hovers ? 1e-6 : dice.between(1e-7, 1e-2);
    const double gap_m = parts && !hovers ? 1e-8 : std::fabs(speed_mps) * after_s + touch_m;
    span = std::max<TickCount>(4, ticks_after(hovers ? 1e-4 : 2 * after_s));
    for (Flyer* flyer : {&first_, &second_}) {
      FreeFlight& flight = flyer->flight;
      flight.begin = began;
      flight.orientation = math::normalized(testing::random_turn(dice));
      if (!hovers && dice.below(3) != 0)
        flight.angular_velocity_radps = dice.between(1e-6, 30) * direction(dice);
      if (both_fly || (flyer == &first_ && !hovers && dice.one_in(2)))
        flight.acceleration_mps2 = pull_mps2;
    }
    plane_ = {.normal = direction(dice), .offset_m = 0};
    plane_.offset_m = math::dot(plane_.normal, about_m);
    const Vec3 aside_m = (first_.reach_m() + second_.reach_m()) * direction(dice);
    pass(second_, about_m, common_mps);
    pass(first_, about_m + aside_m, common_mps);
    const Vec3 normal = contact_at(begin).normal;
    const Vec3 slides_mps =
        !hovers && dice.one_in(2) ? Vec3(dice.vector_within(std::fabs(speed_mps))) : zero();
    pass(first_, about_m + aside_m,
         common_mps + slides_mps - (speed_mps + math::dot(slides_mps, normal)) * normal);
    for (int i = 0; i < 4; ++i) {
      const PieceContact contact = contact_at(begin);
      first_.flight.position_m += (gap_m - contact.gap_m) * contact.normal;
    }
  }

  PieceContact contact_at(Tick tick) const {
    if (other_ == Other::plane) return contact_of(plane_, first_at(tick));
    return contact_of(second_at(tick), first_at(tick));
  }
  /// Returns whether the bodies touch at a vertex but at no face (convex_search.h, invariant 3).
  bool touches_with_a_vertex(Tick tick) const {
    if (other_ == Other::plane) return false;
    const MovingPiece a = second_at(tick);
    const MovingPiece b = first_at(tick);
    const Closest closest = closest_cold(*a.view, a.pose, *b.view, b.pose);
    const auto either_is = [&](FeatureKind kind) {
      return closest.feature_a.kind == kind || closest.feature_b.kind == kind;
    };
    return a.radius_m + b.radius_m == 0 && closest.gap_m <= touch_m &&
           either_is(FeatureKind::vertex) && !either_is(FeatureKind::face);
  }
  Examined examine(Tick tick, SeparationCache& cache, PieceContact& contact) const {
    if (other_ == Other::plane) {
      Examined above;
      const MovingPiece first = first_at(tick);
      const MovingPoint centre{.position_m = first.pose.position_m,
                               .velocity_mps = first.velocity_mps,
                               .acceleration_mps2 = first.acceleration_mps2};
      if (sphere_above(plane_, centre, first.reach_m, tick, above)) return above;
      return examine_plane(plane_, first, tick, touch_m, contact);
    }
    return examine_pieces(second_at(tick), first_at(tick), tick, touch_m, cache, contact);
  }

  double touch_m = k_touch_m;
  Tick begin{};        ///< first tick of the search
  TickCount span = 0;  ///< length of the search

 private:
  static Vec3 zero() { return Vec3::Zero(); }
  /// Gives the body a place and a velocity at the first tick of the search.
  void pass(Flyer& flyer, const Vec3& place_m, const Vec3& velocity_mps) const {
    FreeFlight& flight = flyer.flight;
    const double s = seconds(begin - flight.begin);
    flight.velocity_mps = velocity_mps - s * flight.acceleration_mps2;
    flight.position_m = place_m - s * (flight.velocity_mps + 0.5 * s * flight.acceleration_mps2);
  }
  MovingPiece first_at(Tick tick) const { return first_.at(tick, first_view_); }
  MovingPiece second_at(Tick tick) const {
    MovingPiece second = second_.at(tick, second_view_);
    if (other_ == Other::stays) {
      second = testing::standing(second_.at(begin, second_view_));
    } else if (other_ == Other::sphere) {
      second = testing::ball_of(second, second_.reach_m(), centre_);
    }
    return second;
  }

  Other other_;
  Flyer first_;
  Flyer second_;
  ConvexView first_view_;
  ConvexView second_view_;
  PointPiece point_{Vec3::Zero()};
  ConvexView centre_ = point_.view();
  HalfSpace plane_;
};

/// A body that lies nearly flat on another body, within touch distance. The upper body rocks slowly
/// and may slide; the lower body may be at rest.
class Rocking {
 public:
  static constexpr TickCount k_span = TickCount{1} << 22U;  // 4 ms

  explicit Rocking(Dice& dice)
      : below_{rocking_body(dice), {}},
        above_{below_.body, {}},
        below_view_(below_.part().view()),
        above_view_(above_.part().view()),
        stays_(dice.one_in(2)) {
    begin = Tick{TickCount{1} << 20U};
    const Quat about = math::normalized(testing::random_turn(dice));
    double half_m = 0;
    for (const Vec3& vertex : below_.part().vertices_m())
      half_m = std::max(half_m, vertex.z());
    const Quat yaw =
        math::quaternion_of_rotation_vector({0, 0, dice.one_in(3) ? 0 : dice.within(3)});
    const Quat tilt =
        math::quaternion_of_rotation_vector(dice.between(1e-9, 3e-6) / half_m * direction(dice));
    const Vec3 aside_m = half_m * Vec3(dice.within(0.9), dice.within(0.9), 2);
    below_.flight.begin = above_.flight.begin = begin;
    below_.flight.orientation = about;
    above_.flight.orientation = math::normalized(about * tilt * yaw);
    below_.flight.position_m = 0.1 * direction(dice);
    above_.flight.position_m = below_.flight.position_m + about * aside_m;
    // A pair that rocks fast must separate fast; otherwise every tick could be a collision.
    const bool fast = dice.one_in(2);
    const double turns_radps = fast ? 10 : 1e-2;
    above_.flight.angular_velocity_radps = dice.between(1e-7, turns_radps) * direction(dice);
    if (!stays_ && dice.one_in(2))
      below_.flight.angular_velocity_radps = dice.between(1e-7, turns_radps) * direction(dice);
    if (dice.one_in(2)) above_.flight.velocity_mps = dice.between(1e-6, 0.3) * direction(dice);
    if (dice.one_in(2)) {
      above_.flight.acceleration_mps2 = Vec3(0, 0, -9.81);
      if (!stays_) below_.flight.acceleration_mps2 = above_.flight.acceleration_mps2;
    }
    // The bodies separate, or approach too slowly to collide.
    const double gap_m = dice.between(1e-10, 9e-8);
    double rate_mps = fast ? dice.between(1e-5, 1e-2) : dice.between(1e-10, 1e-4);
    if (!fast && dice.one_in(2)) rate_mps = -dice.between(1e-12, 0.9 * k_approach_mps);
    for (int i = 0; i < 4; ++i) {
      const PieceContact contact = contact_of(below_at(begin), above_at(begin));
      above_.flight.position_m += (gap_m - contact.gap_m) * contact.normal;
      above_.flight.velocity_mps += (rate_mps - contact.rate_mps) * contact.normal;
    }
  }

  MovingPiece below_at(Tick tick) const {
    return stays_ ? testing::standing(below_.at(begin, below_view_)) : below_.at(tick, below_view_);
  }
  MovingPiece above_at(Tick tick) const { return above_.at(tick, above_view_); }
  /// The features that the normal follows: a face of one body, or an edge of each body. Invariant 3
  /// of convex_search.h covers no other normals.
  struct Normal {
    std::optional<Feature> below;
    std::optional<Feature> above;
    bool is_covered() const { return below.has_value() || above.has_value(); }
    friend bool operator==(const Normal&, const Normal&) = default;
  };
  Normal normal_at(Tick tick) const {
    const MovingPiece a = below_at(tick);
    const MovingPiece b = above_at(tick);
    const Closest closest = closest_cold(*a.view, a.pose, *b.view, b.pose);
    if (closest.feature_a.kind == FeatureKind::face)
      return {.below = closest.feature_a, .above = {}};
    if (closest.feature_b.kind == FeatureKind::face)
      return {.below = {}, .above = closest.feature_b};
    if (closest.feature_a.kind == FeatureKind::edge && closest.feature_b.kind == FeatureKind::edge)
      return {.below = closest.feature_a, .above = closest.feature_b};
    return {};
  }

  Tick begin{};

 private:
  /// A body that can lie on a face of an equal body.
  static BodyShape rocking_body(Dice& dice) {
    constexpr std::array<Solid, 3> k_solids{Solid::die, Solid::prism, Solid::slab};
    const double size_m = dice.between(5e-3, 0.05);
    return body_of(k_solids[dice.below(k_solids.size())], size_m);
  }

  Flyer below_;
  Flyer above_;
  ConvexView below_view_;
  ConvexView above_view_;
  bool stays_;
};

TEST(ConvexSearch, SkipsNoCollision) {
  // Goal: a search skips no tick at which the pieces collide, even if they collide only because of
  // rounding (convex_search.h, invariant 3). Method: let random pairs approach slowly or fast,
  // hover, or touch and then separate. Vary the pairs' distance from the origin, rotation, gravity
  // and flight time. Compute the contact from scratch at the last skipped ticks and at random
  // skipped ticks; it must not be a collision.
  std::uint64_t looks = 0;
  std::uint64_t compared = 0;
  std::uint64_t collisions = 0;
  const std::uint64_t count = property::long_run() ? 1'000'000 : property::of_tier(4'000, 20'000);
  for (const std::uint64_t n : property::cases(count)) {
    if (HasFailure()) break;
    Dice dice(k_seed, n);
    const Approach approach(dice);
    const Tick end = approach.begin + approach.span;
    SeparationCache cache;
    const std::uint64_t looks_before = looks;
    for (Tick tick = approach.begin; tick < end;) {
      ++looks;
      ASSERT_LT(looks - looks_before, 20'000U) << "it walks from tick to tick";
      PieceContact contact;
      const Examined examined = approach.examine(tick, cache, contact);
      if (examined.collides) {
        ++collisions;
        break;
      }
      ASSERT_GT(examined.next, tick);
      const Tick next = std::min(examined.next, end);
      const bool is_covered = !approach.touches_with_a_vertex(tick);
      const auto look = [&](Tick skipped) {
        if (skipped <= tick || skipped >= next || !is_covered) return;
        ++compared;
        const PieceContact there = approach.contact_at(skipped);
        ASSERT_FALSE(collides(there, approach.touch_m))
            << fmt::format("from {}, next {}, but at {}: gap {} m, rate {} m/s", tick.value,
                           next.value, skipped.value, there.gap_m, there.rate_mps);
      };
      for (const TickCount before : {1, 2, 3, 10})
        look(next - before);
      look(tick + static_cast<TickCount>(dice.below(static_cast<std::uint64_t>(next - tick))));
      if (HasFailure()) break;
      tick = next;
    }
  }
  fmt::print("{} looks, {} collisions, contacts at {} skipped ticks\n", looks, collisions,
             compared);
  if (property::all_cases()) {
    EXPECT_GT(collisions, count / 2);
    EXPECT_GT(compared, count);
  }
}

TEST(ConvexSearch, SkipsNoCollisionOfThoseThatRock) {
  // Goal: a search skips no collision of touching pieces (invariant 3), even if rounding and small
  // accelerations decide which vertex is lowest. Method: let random bodies rock and slide while
  // they lie nearly flat on each other. Compute contacts from scratch at the last skipped ticks and
  // at random skipped ticks. If the normal begins to follow another face, the invariant no longer
  // holds. Even then, the search misses hardly any collision.
  std::uint64_t looks = 0;
  std::uint64_t collisions = 0;
  std::uint64_t missed = 0;
  const std::uint64_t count = property::long_run() ? 500'000 : property::of_tier(4'000, 20'000);
  for (const std::uint64_t n : property::cases(count)) {
    if (HasFailure()) break;
    Dice dice(k_seed, n);
    const Rocking pair(dice);
    const Tick end = pair.begin + Rocking::k_span;
    SeparationCache cache;
    const std::uint64_t looks_before = looks;
    bool is_over = false;
    for (Tick tick = pair.begin; tick < end && !is_over && !HasFailure();) {
      ++looks;
      ASSERT_LT(looks - looks_before, 20'000U) << "it walks from tick to tick";
      PieceContact contact;
      const Examined examined =
          examine_pieces(pair.below_at(tick), pair.above_at(tick), tick, k_touch_m, cache, contact);
      if (examined.collides) {
        ++collisions;
        break;
      }
      ASSERT_GT(examined.next, tick);
      const Tick next = std::min(examined.next, end);
      const Rocking::Normal normal = pair.normal_at(tick);
      const auto look = [&](Tick skipped) {
        if (is_over || skipped <= tick || skipped >= next || !normal.is_covered()) return;
        const PieceContact there = contact_of(pair.below_at(skipped), pair.above_at(skipped));
        if (!collides(there, k_touch_m)) return;
        is_over = true;
        ++missed;
        EXPECT_FALSE(pair.normal_at(skipped) == normal)
            << fmt::format("from {}, next {}, but at {}: gap {} m, rate {} m/s", tick.value,
                           next.value, skipped.value, there.gap_m, there.rate_mps);
      };
      for (const TickCount before : {1, 2, 3, 5, 10, 20, 40})
        look(next - before);
      for (int i = 0; i < 8; ++i)
        look(tick + static_cast<TickCount>(dice.below(static_cast<std::uint64_t>(next - tick))));
      tick = next;
    }
  }
  fmt::print("{} looks, {} collisions, {} missed where the normal is another face's\n", looks,
             collisions, missed);
  if (property::all_cases()) {
    EXPECT_GT(collisions, count / 5);
    EXPECT_LE(missed, count / 10'000);
  }
}

TEST(ConvexSearch, VerticesThatFallAlmostAlikeAreLookedAt) {
  // Goal: if several vertices are equally low and fall at almost the same speed, the search still
  // finds the collision of the fastest vertex. The first vertex, which the bounds use, is too slow
  // to collide. Method: hold a cube flat above a cube at rest and above a plane, within touch
  // distance. The cube falls slightly too slowly to collide. The cube's rotation, in either
  // direction, makes one vertex just fast enough.
  Flyer below{testing::die_of(0.02), {}};
  Flyer above = below;
  const ConvexView below_view = below.part().view();
  const ConvexView above_view = above.part().view();
  const Tick begin{1};
  below.flight.begin = above.flight.begin = begin;
  above.flight.position_m = Vec3(0.003, 0.002, 0.02 + 0.5 * k_touch_m);
  above.flight.velocity_mps = Vec3(0, 0, -0.98 * k_approach_mps);
  const HalfSpace plane{.normal = Vec3(0, 0, 1), .offset_m = 0.01};
  const MovingPiece stays = testing::standing(below.at(begin, below_view));
  for (const double turns : {9.0, -9.0}) {
    above.flight.angular_velocity_radps = Vec3(turns * k_approach_mps, 0, 0);
    const MovingPiece now = above.at(begin, above_view);
    const MovingPiece then = above.at(begin + 1000, above_view);
    SeparationCache cache;
    PieceContact contact;
    const Examined of_pieces = examine_pieces(stays, now, begin, k_touch_m, cache, contact);
    ASSERT_TRUE(collides(contact_of(stays, then), k_touch_m));
    EXPECT_TRUE(of_pieces.collides || of_pieces.next <= begin + 1000) << of_pieces.next.value;
    const Examined of_plane = examine_plane(plane, now, begin, k_touch_m, contact);
    ASSERT_TRUE(collides(contact_of(plane, then), k_touch_m));
    EXPECT_TRUE(of_plane.collides || of_plane.next <= begin + 1000) << of_plane.next.value;
  }
}

}  // namespace sleight::physics::convex_search_test
