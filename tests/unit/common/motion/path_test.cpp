// Goal: an animation returns each body's position at any time, and refuses unsound segments.
// Method: use a small motion of two bodies. Break one property of a segment at a time.
#include "common/motion/path.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <vector>

#include "tests/support/facts.h"

namespace sleight::motion {
namespace {

using ::testing::HasSubstr;

std::vector<Segment> two_bodies() {
  return {{.body = 0, .start_s = 1, .position_m = {0, 0, 1}, .velocity_mps = {1, 0, 0}},
          {.body = 0, .start_s = 2, .cause = Cause::hit, .partner = 1, .position_m = {1, 0, 1}},
          {.body = 1, .start_s = 0, .position_m = {5, 0, 0}},
          {.body = 0,
           .start_s = 2,
           .mode = Mode::resting,
           .cause = Cause::rest,
           .position_m = {1, 0, 1}}};
}

TEST(Animation, TellsWhereBodiesAre) {
  const auto made = Animation::of(two_bodies(), 3);
  ASSERT_TRUE(made.ok());
  const Animation& animation = made.value();
  EXPECT_EQ(animation.bodies(), 3U);
  EXPECT_EQ(animation.end_s(), 2);
  EXPECT_EQ(animation.segment_count(), 4U);
  EXPECT_FALSE(animation.path(2).enters());
  EXPECT_FALSE(animation.path(2).pose_at(1));
  const Path& path = animation.path(0);
  EXPECT_EQ(path.start_s(), 1);
  EXPECT_EQ(path.rest_s(), 2);
  EXPECT_EQ(path.segment_at(0.999), nullptr);
  EXPECT_EQ(path.segment_at(1), &path.segments()[0]);
  EXPECT_EQ(path.segment_at(1.999), &path.segments()[0]);
  // If several segments begin at once, the last one applies.
  EXPECT_EQ(path.segment_at(2), &path.segments()[2]);
  EXPECT_EQ(path.centre_at(1.5)->x(), 0.5);
  EXPECT_EQ(path.centre_at(9)->x(), 1);
}

TEST(Animation, RefusesWhatIsNoMotion) {
  EXPECT_TRUE(Animation::of({}, 0).ok());
  const auto refused = [](std::size_t bodies, const std::function<void(Segment&)>& change) {
    std::vector<Segment> segments = two_bodies();
    change(segments[1]);
    const auto made = Animation::of(segments, bodies);
    return made.ok() ? std::string("taken") : made.error();
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refused(2, [](Segment&) {}), "taken");
  EXPECT_THAT(refused(1, [](Segment&) {}), tests::HasFacts("body 2|only 1"));
  EXPECT_THAT(refused(2, [](Segment& s) { s.start_s = 0.5; }), HasSubstr("time order"));
  EXPECT_THAT(refused(2, [&](Segment& s) { s.start_s = nan; }), HasSubstr("invalid numbers"));
  EXPECT_THAT(refused(2, [&](Segment& s) { s.position_m.z() = nan; }),
              HasSubstr("invalid numbers"));
  EXPECT_THAT(refused(2, [](Segment& s) { s.velocity_mps.y() = -1e300; }),
              HasSubstr("invalid numbers"));
  EXPECT_THAT(refused(2, [](Segment& s) { s.orientation.w() = 2; }), HasSubstr("not a rotation"));
  EXPECT_THAT(refused(2, [&](Segment& s) { s.orientation.x() = nan; }),
              HasSubstr("not a rotation"));
}

}  // namespace
}  // namespace sleight::motion
