// Tests that searches of round pieces skip no collision.
#include "worker/physics/collision/round_search.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "common/math/rotation.h"
#include "tests/support/property.h"
#include "tests/unit/worker/physics/collision/flyer.h"
#include "tests/unit/worker/physics/collision/surface_tables.h"
#include "worker/physics/collision/convex_search.h"
#include "worker/physics/motion/motion_bounds.h"
#include "worker/physics/motion/rotation_bounds.h"
#include "worker/physics/motion/rotation_track.h"
#include "worker/physics/shape/round_solids.h"
#include "worker/physics/shape/shapes.h"
#include "worker/physics/shape/small_pieces.h"

namespace sleight::physics::round_search_test {

using testing::Dice;

Vec3 direction(Dice& dice) {
  return math::normalized(dice.vector_within(1));
}

struct Flyer {
  Compound compound;
  Inertia inertia;
  FreeFlight flight{};

  MovingPiece at(Tick tick, const ConvexView& view) const {
    const RotationBounds bounds = rotation_bounds(flight, inertia);
    const double reach_m = compound.r_outer_m();
    return {.view = &view,
            .radius_m = 0,
            .pose = placed({position_at(flight, tick), orientation_at(flight, inertia, tick)}),
            .coordinates_m = coordinates_m_max(flight, tick),
            .velocity_mps = velocity_at(flight, tick),
            .acceleration_mps2 = flight.acceleration_mps2,
            .angular_velocity_radps = angular_velocity_at(flight, inertia, tick),
            .turning_acceleration_mps2 = turning_acceleration_mps2_max(bounds, reach_m),
            .turns_evenly = inertia.symmetry == InertiaSymmetry::spherical,
            .reach_m = reach_m};
  }
};

Flyer flyer_of(Dice& dice, bool may_be_polyhedron) {
  const double size_m = dice.between(5e-3, 0.1);
  const auto round = [](const RoundResult& made) {
    return Flyer{.compound = {.parts = {}, .round_parts = {made.value().parts.front()}},
                 .inertia = made.value().inertia};
  };
  switch (dice.below(may_be_polyhedron ? 7 : 6)) {
    case 0:
      return round(cylinder(size_m, 2 * size_m, 0.02 * size_m, 1000));
    case 1:
      return round(coin(size_m, 0.2 * size_m, 1000));
    case 2:
      return round(capsule(0.5 * size_m, size_m, 1000));
    case 3:
      return round(cone(size_m, 1.5 * size_m, 0.02 * size_m, 1000));
    case 4:
      return round(rounded_box(size_m * Vec3(1, 1.4, 0.6), 0.05 * size_m, 1000));
    case 5:
      return round(bowling_pin(1.55));
    default: {
      BodyShape shape = in_body_frame(std::vector{box(size_m * Vec3(1, 1.5, 0.5)).value()}, 1000,
                                      InertiaSymmetry::general)
                            .value();
      return {.compound = {.parts = std::move(shape.parts)}, .inertia = shape.inertia};
    }
  }
}

/// Two bodies that approach each other, or a body that approaches a plane or a body at rest.
class Approach {
 public:
  enum class Other : std::uint8_t { flies, stays, sphere, plane };

  explicit Approach(Dice& dice)
      : other_(static_cast<Other>(dice.below(4))),
        first_(flyer_of(dice, false)),
        second_(flyer_of(dice, true)),
        first_view_(first_.compound.view(0)),
        second_view_(second_.compound.view(0)) {
    const Vec3 about_m = dice.between(1e-2, 10) * direction(dice);
    const bool both_fly = other_ == Other::flies;
    const Vec3 common_mps = both_fly ? Vec3(dice.between(1e-3, 10) * direction(dice)) : zero();
    const Vec3 pull_mps2 = dice.one_in(3) ? zero() : Vec3(0, 0, -9.81);
    begin = Tick{static_cast<TickCount>(dice.below(std::uint64_t{1} << 30U))};
    const bool parts = dice.one_in(5);
    const double speed_mps = (parts ? -1 : 1) * dice.between(1e-5, 3);
    const double after_s = dice.between(1e-6, 1e-2);
    const double gap_m = std::fabs(speed_mps) * after_s + 1.01 * k_touch_m;
    span = std::max<TickCount>(16, ticks_after(2 * after_s));
    for (Flyer* flyer : {&first_, &second_}) {
      flyer->flight.begin = begin;
      flyer->flight.orientation = math::normalized(testing::random_turn(dice));
      if (dice.below(4) != 0)
        flyer->flight.angular_velocity_radps = dice.between(1e-3, 30) * direction(dice);
      if (both_fly || flyer == &first_) flyer->flight.acceleration_mps2 = pull_mps2;
    }
    if (other_ != Other::flies) second_.flight.acceleration_mps2 = zero();
    plane_ = {.normal = direction(dice), .offset_m = 0};
    plane_.offset_m = math::dot(plane_.normal, about_m);
    second_.flight.position_m = about_m;
    second_.flight.velocity_mps = common_mps;
    first_.flight.position_m =
        about_m + (first_.compound.r_outer_m() + second_.compound.r_outer_m()) * direction(dice);
    first_.flight.velocity_mps = common_mps;
    const Vec3 normal = contact_at(begin).normal;
    first_.flight.velocity_mps += dice.vector_within(std::fabs(speed_mps)) - speed_mps * normal;
    for (int i = 0; i < 20; ++i) {
      const PieceContact contact = contact_at(begin);
      first_.flight.position_m += (gap_m - contact.gap_m) * contact.normal;
    }
  }

  PieceContact contact_at(Tick tick) const {
    return other_ == Other::plane ? contact_of(plane_, first_.at(tick, first_view_))
                                  : contact_of(second_at(tick), first_.at(tick, first_view_));
  }
  Examined examine(Tick tick) const {
    PieceContact contact;
    SeparationCache cache;
    return other_ == Other::plane
               ? examine_plane(plane_, first_.at(tick, first_view_), tick, k_touch_m, contact)
               : examine_pieces(second_at(tick), first_.at(tick, first_view_), tick, k_touch_m,
                                cache, contact);
  }

  std::string words() const {
    return fmt::format("other {}, inertia {}, at {} m, turning {} rad/s", static_cast<int>(other_),
                       static_cast<int>(first_.inertia.symmetry),
                       math::norm(first_.flight.position_m),
                       math::norm(first_.flight.angular_velocity_radps));
  }

  Tick begin{};        ///< first tick of the search
  TickCount span = 0;  ///< length of the search

 private:
  static Vec3 zero() { return Vec3::Zero(); }
  MovingPiece second_at(Tick tick) const {
    MovingPiece second = second_.at(tick, second_view_);
    if (other_ == Other::stays) {
      second = testing::standing(second_.at(begin, second_view_));
    } else if (other_ == Other::sphere) {
      second = testing::ball_of(second, second_.compound.r_outer_m(), centre_);
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

TEST(RoundSearch, SkipsNoCollision) {
  // Goal: while two round pieces are apart, a search skips no tick at which they touch
  // (round_search.h, invariant 2). Method: let a random piece approach another piece, a ball, a
  // plane or a piece at rest. Compute the gap from scratch at random skipped ticks and at the last
  // skipped ticks; the pieces must not touch.
  const std::uint64_t count = property::long_run() ? 60'000 : property::of_tier(300, 1500);
  std::uint64_t skipped = 0;
  std::uint64_t looks = 0;
  std::uint64_t met = 0;
  for (const std::uint64_t n : property::cases(count)) {
    Dice dice(3, n);
    const Approach approach(dice);
    Tick tick = approach.begin;
    const Tick end = approach.begin + approach.span;
    for (int look = 0; look < 200 && tick < end; ++look) {
      ++looks;
      const Examined examined = approach.examine(tick);
      if (examined.collides) {
        ++met;
        break;
      }
      const bool in_touch = touches(approach.contact_at(tick).gap_m);
      ASSERT_GT(examined.next, tick) << n;
      const Tick next = std::min(examined.next, end);
      for (int i = 0; i < 16 && !in_touch; ++i) {
        const TickCount to = next - tick;
        const TickCount back =
            i < 8 ? i + 1 : static_cast<TickCount>(dice.below(static_cast<std::uint64_t>(to)));
        if (back >= to || back < 1) continue;
        const PieceContact contact = approach.contact_at(next + -back);
        ++skipped;
        ASSERT_FALSE(touches(contact.gap_m))
            << n << ", look " << look << ": " << back << " ticks before the next, gap "
            << contact.gap_m << ", " << approach.words();
      }
      tick = examined.next;
    }
  }
  fmt::print("{} skipped ticks looked at, {} looks, {} of {} met\n", skipped, looks, met, count);
  if (!property::all_cases()) return;
  EXPECT_GT(met, count / 3);
  EXPECT_GT(skipped, 10 * count);
  EXPECT_LT(looks, 30 * count);
}

}  // namespace sleight::physics::round_search_test
