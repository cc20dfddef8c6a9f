#include "worker/physics/scene/friction_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "common/random/stream.h"
#include "tests/unit/worker/physics/scene/random_friction.h"

namespace sleight::physics::friction_map_test {

using ::testing::HasSubstr;
using testing::random_rectangles;

random::Stream stream_of(std::uint64_t n) {
  return random::Stream({.seed = 20'261'128, .purpose = random::Purpose::prior}, n);
}

/// Returns the last rectangle that contains a point of the plane z = 0. Uses the definition.
int last_at(const std::vector<FrictionRectangle>& rectangles, double u_m, double v_m) {
  int last = -1;
  for (std::size_t i = 0; i < rectangles.size(); ++i) {
    const FrictionRectangle& r = rectangles[i];
    if (u_m >= r.u_min_m && u_m < r.u_max_m && v_m >= r.v_min_m && v_m < r.v_max_m)
      last = static_cast<int>(i);
  }
  return last;
}

Vec3 on_path(const MapPath& path, double s) {
  return path.place_m + s * path.velocity_mps + (0.5 * s * s) * path.acceleration_mps2;
}

TEST(FrictionMap, TellsTheLastRectangle) {
  // Goal: at any point, even on a border, a friction map has the friction of the last rectangle
  // that contains the point.
  for (std::uint64_t n = 0; n < 50; ++n) {
    random::Stream stream = stream_of(n);
    const auto rectangles = random_rectangles(stream, static_cast<int>(n * 3), 1);
    const FrictionMap map = FrictionMap::make({}, rectangles).value();
    for (int i = 0; i < 2000; ++i) {
      double u_m = scenes::between(stream, -1.5, 1.5);
      double v_m = scenes::between(stream, -1.5, 1.5);
      if (!rectangles.empty() && i % 4 == 0) {
        const FrictionRectangle& r = rectangles[static_cast<std::size_t>(i) % rectangles.size()];
        u_m = i % 8 == 0 ? r.u_min_m : r.u_max_m;
        v_m = i % 3 == 0 ? r.v_min_m : v_m;
      }
      const int last = last_at(rectangles, u_m, v_m);
      const std::optional<double> found = map.friction_at({u_m, v_m, 0.3});
      ASSERT_EQ(found.has_value(), last >= 0);
      if (found) {
        ASSERT_EQ(*found, rectangles[static_cast<std::size_t>(last)].friction);
      }
    }
  }
}

TEST(FrictionMap, FindsTheFirstBorder) {
  // Goal: border_s() returns the time at which another rectangle's friction begins to apply on a
  // path. Method: on random parabolas over random maps, look up the rectangle that applies at
  // closely spaced times. The rectangle must stay the same up to border_s(). Just after border_s(),
  // another rectangle must apply.
  int met = 0;
  for (std::uint64_t n = 0; n < 2000; ++n) {
    random::Stream stream = stream_of(n);
    const auto rectangles = random_rectangles(stream, static_cast<int>(n % 40), 1);
    const FrictionMap map = FrictionMap::make({}, rectangles).value();
    MapPath path{.place_m = scenes::vector_between(stream, -1, 1),
                 .velocity_mps = scenes::vector_between(stream, -1, 1),
                 .acceleration_mps2 = scenes::vector_between(stream, -1, 1)};
    if (n % 5 == 0) path.acceleration_mps2 = Vec3::Zero();
    const double most_s = 2;
    const double border_s = map.border_s(path, most_s);
    const auto last_after = [&](double s) {
      const Vec3 place_m = on_path(path, s);
      return last_at(rectangles, place_m.x(), place_m.y());
    };
    const int first = last_after(0);
    constexpr int k_looks = 2000;
    for (int i = 0; i < k_looks; ++i)
      ASSERT_EQ(last_after(border_s * (i + 0.5) / k_looks), first) << n << ", " << i;
    if (border_s == most_s) continue;
    ++met;
    // A path may cut a corner for a moment, after which the first rectangle applies again.
    ASSERT_NE(last_after(border_s + 1e-11), first) << n;
  }
  EXPECT_GT(met, 1000);
}

TEST(FrictionMap, RefusesWhatIsNone) {
  // Goal: the error for an invalid friction map names the faulty rectangle or value.
  const auto error_of = [](const MapFrame& frame, std::vector<FrictionRectangle> rectangles) {
    const auto made = FrictionMap::make(frame, std::move(rectangles));
    return made ? std::string() : made.error();
  };
  const FrictionRectangle good{
      .u_min_m = 0, .u_max_m = 1, .v_min_m = 0, .v_max_m = 1, .friction = 0.1};
  EXPECT_EQ(error_of({}, {good}), "");
  EXPECT_EQ(error_of({}, std::vector<FrictionRectangle>(4096, good)), "");
  EXPECT_THAT(error_of({}, std::vector<FrictionRectangle>(4097, good)),
              HasSubstr("maximum of 4096"));
  FrictionRectangle bad = good;
  bad.u_max_m = 0;
  EXPECT_THAT(error_of({}, {good, bad}), HasSubstr("rectangle 1: u from 0 to 0 m"));
  bad = good;
  bad.v_min_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(error_of({}, {bad}), HasSubstr("rectangle 0"));
  bad = good;
  bad.friction = -0.1;
  EXPECT_THAT(error_of({}, {bad}), HasSubstr("friction is -0.1, expected 0 to"));
  EXPECT_THAT(error_of({.u = {1, 0, 0}, .v = {0.1, 1, 0}}, {good}), HasSubstr("length 1"));
  EXPECT_THAT(error_of({.origin_m = {1e7, 0, 0}}, {good}), HasSubstr("origin"));
}

}  // namespace sleight::physics::friction_map_test
