// Goal: between keys, a player shows every kind of motion to within 0.1 mm and 0.2 degrees of the
// archive. Method: interpolate the keys of random motions at random times, with both interpolations
// that players use. Compare the poses with the closed forms. Coarse keys must fail.
#include "clients/export/keys.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/random/stream.h"
#include "tests/support/property.h"
#include "tests/unit/clients/export/read_glb.h"

namespace sleight::gltf {
namespace {

using math::Quat;
using math::Vec3;
using motion::Segment;
using ::testing::HasSubstr;
using testing::Track;
using testing::Turning;

constexpr double k_place_m = 1e-4;
constexpr double k_turn_off = 0.2 * 3.141592653589793 / 180;

Vec3 random_vector(random::Stream& stream, double size) {
  return {size * (2 * stream.uniform() - 1), size * (2 * stream.uniform() - 1),
          size * (2 * stream.uniform() - 1)};
}

Segment after(Segment before, double start_s) {
  Segment next = before;
  next.start_s = start_s;
  next.position_m = position_at(before, start_s);
  next.orientation = orientation_at(before, start_s);
  return next;
}

motion::Path thrown(random::Stream& stream, double* end_s) {
  motion::Path path(0);
  Segment segment{.start_s = 0.3 * stream.uniform(),
                  .position_m = random_vector(stream, 0.5),
                  .orientation = math::quaternion_of_rotation_vector(random_vector(stream, 3))};
  const int segments = 1 + static_cast<int>(30 * stream.uniform());
  for (int i = 0; i < segments; ++i) {
    const bool is_sliding = stream.uniform() < 0.3;
    segment.mode = is_sliding ? motion::Mode::sliding : motion::Mode::flying;
    segment.velocity_mps = random_vector(stream, 4);
    segment.acceleration_mps2 = is_sliding ? random_vector(stream, 5) : Vec3(0, 0, -9.81);
    segment.angular_velocity_radps = random_vector(stream, 80);
    segment.angular_acceleration_radps2 = Vec3::Zero();
    if (is_sliding) segment.angular_acceleration_radps2 = random_vector(stream, 700);
    path.append(segment);
    segment = after(segment, segment.start_s + 0.25 * stream.uniform() * stream.uniform());
  }
  segment.mode = motion::Mode::resting;
  segment.velocity_mps = segment.acceleration_mps2 = Vec3::Zero();
  segment.angular_velocity_radps = segment.angular_acceleration_radps2 = Vec3::Zero();
  path.append(segment);
  *end_s = segment.start_s;
  return path;
}

template <class Value>
Track track_of(const Channel<Value>& channel) {
  Track track{.interpolation = "LINEAR"};
  for (const float time_s : channel.times_s)
    track.times_s.push_back(static_cast<double>(time_s));
  for (const Value& value : channel.values)
    track.values.emplace_back(value.begin(), value.end());
  return track;
}

struct Off {
  double place_m = 0;
  double turn_rad = 0;
};

/// Returns the largest error of the shown pose at `times` random moments.
Off most_off(const motion::Path& path, const BodyKeys& keys, double end_s, int times,
             random::Stream& stream) {
  const Track places = track_of(keys.translation);
  const Track turns = track_of(keys.rotation);
  const double start_s = static_cast<double>(keys.enters_s) + 1e-6;
  Off off;
  for (int i = 0; i < times; ++i) {
    const double t_s = start_s + (end_s + 0.01 - start_s) * stream.uniform();
    const auto pose = path.pose_at(t_s);
    off.place_m =
        std::max(off.place_m,
                 math::norm(Vec3(testing::z_up(testing::played(places, t_s)) - pose->centre_m)));
    for (const Turning turning : {Turning::slerp, Turning::normalised}) {
      const Quat shown = testing::z_up_turn(testing::played(turns, t_s, turning));
      off.turn_rad = std::max(off.turn_rad, testing::apart_rad(shown, pose->orientation));
    }
  }
  return off;
}

void expect_in_order(const BodyKeys& keys) {
  const auto ascends = [](const std::vector<float>& times_s) {
    return std::ranges::adjacent_find(times_s, std::greater_equal<>()) == times_s.end();
  };
  EXPECT_TRUE(ascends(keys.translation.times_s));
  EXPECT_TRUE(ascends(keys.rotation.times_s));
  EXPECT_EQ(keys.translation.times_s.size(), keys.translation.values.size());
  EXPECT_EQ(keys.rotation.times_s.size(), keys.rotation.values.size());
  for (std::size_t i = 1; i < keys.rotation.values.size(); ++i) {
    float along = 0;
    for (std::size_t k = 0; k < 4; ++k)
      along += keys.rotation.values[i - 1][k] * keys.rotation.values[i][k];
    EXPECT_GT(along, 0);
  }
}

TEST(Keys, KeepPlacesAndTurnsWithinTheTolerance) {
  for (const std::uint64_t n : property::cases(400)) {
    random::Stream stream({.seed = 26, .purpose = random::Purpose::scene}, n);
    double end_s = 0;
    const motion::Path path = thrown(stream, &end_s);
    const auto keys = keys_of(path, end_s);
    ASSERT_TRUE(keys.ok());
    expect_in_order(keys.value());
    const Off off = most_off(path, keys.value(), end_s, 100, stream);
    EXPECT_LT(off.place_m, k_place_m);
    EXPECT_LT(off.turn_rad, k_turn_off);
    // Negative control: one key per film frame is too coarse.
    if (end_s < 0.5) continue;
    const Off of_frames = most_off(path, keys_of(path, end_s, 10).value(), end_s, 100, stream);
    EXPECT_GT(of_frames.place_m, k_place_m);
    EXPECT_GT(of_frames.turn_rad, k_turn_off);
  }
}

TEST(Keys, FollowALongFastSpin) {
  random::Stream stream({.seed = 27, .purpose = random::Purpose::scene}, 0);
  motion::Path path(0);
  path.append({.position_m = {1, 2, 3}, .angular_velocity_radps = {300, -200, 350}});
  path.append(after(path.segments()[0], 20));
  const auto keys = keys_of(path, 20.5);
  ASSERT_TRUE(keys.ok());
  expect_in_order(keys.value());
  const Off off = most_off(path, keys.value(), 20.5, 500, stream);
  EXPECT_LT(off.place_m, k_place_m);
  EXPECT_LT(off.turn_rad, k_turn_off);
  EXPECT_EQ(keys.value().translation.times_s.size(), 3U);
}

TEST(Keys, AreAtTheRoundedTimesOfEvents) {
  motion::Path path(0);
  path.append({.start_s = 0.1, .position_m = {1, 0, 0}, .velocity_mps = {1, 0, 0}});
  path.append(after(path.segments()[0], 0.7));
  path.append(after(path.segments()[0], 0.9));
  const auto keys = keys_of(path, 0.9).value();
  EXPECT_EQ(keys.enters_s, 0.1F);
  EXPECT_EQ(keys.translation.times_s, (std::vector<float>{0.1F, 0.7F, 0.9F}));
  EXPECT_NEAR(keys.translation.values[1][0], 1.6, 1e-7);
  path.append({.start_s = 0.9, .mode = motion::Mode::resting, .position_m = {1.8, 0, 0}});
  EXPECT_EQ(keys_of(path, 0.9).value().translation.times_s, keys.translation.times_s);
}

TEST(Keys, AreTwoWhereABodyJumps) {
  motion::Path path(0);
  path.append({.velocity_mps = {1, 0, 0}});
  path.append({.start_s = 0.5,
               .mode = motion::Mode::resting,
               .position_m = {0, 0, 2},
               .orientation = math::quaternion_of_rotation_vector({0, 0, 1})});
  const auto keys = keys_of(path, 0.5).value();
  const float next_s = std::nextafter(0.5F, 1.0F);
  EXPECT_EQ(keys.translation.times_s, (std::vector<float>{0, 0.5F, next_s}));
  EXPECT_EQ(keys.translation.values[1], (Float3{0.5F, 0, 0}));
  EXPECT_EQ(keys.translation.values[2], (Float3{0, 2, 0}));
  EXPECT_EQ(keys.rotation.times_s, (std::vector<float>{0, 0.5F, next_s}));
  EXPECT_EQ(keys.rotation.values[1], (Float4{0, 0, 0, 1}));
}

TEST(Keys, OfWhatHardlyMovesAreFew) {
  motion::Path resting(0);
  resting.append({.start_s = 2, .mode = motion::Mode::resting, .position_m = {1, 2, 3}});
  const auto rests = keys_of(resting, 5).value();
  EXPECT_EQ(rests.translation.times_s, std::vector<float>{2});
  EXPECT_EQ(rests.translation.values, (std::vector<Float3>{{1, 3, -2}}));
  EXPECT_EQ(rests.rotation.times_s, std::vector<float>{2});

  // Use a motion of one tick, which is too short for single precision to resolve.
  motion::Path tick(0);
  tick.append({.start_s = 2, .velocity_mps = {1, 0, 0}, .angular_velocity_radps = {1, 0, 0}});
  tick.append(after(tick.segments()[0], 2 + 0x1p-30));
  tick.append({.start_s = 2 + 0x1p-30, .mode = motion::Mode::resting});
  const auto short_one = keys_of(tick, 2 + 0x1p-30).value();
  expect_in_order(short_one);
  EXPECT_EQ(short_one.translation.times_s, std::vector<float>{2});

  motion::Path early(0);
  early.append({.start_s = -3, .velocity_mps = {1, 0, 0}});
  early.append({.start_s = 1, .mode = motion::Mode::resting, .position_m = {4, 0, 0}});
  const auto cut = keys_of(early, 1).value();
  EXPECT_EQ(cut.translation.times_s, (std::vector<float>{0, 1}));
  EXPECT_EQ(cut.translation.values[0][0], 3);
}

TEST(Keys, OfWholeFramesAreThereAlone) {
  random::Stream stream({.seed = 28, .purpose = random::Purpose::scene}, 0);
  for (const double fps : {24.0, 30.0, 23.976}) {
    double end_s = 0;
    const motion::Path path = thrown(stream, &end_s);
    const auto keys = keys_of(path, end_s, fps).value();
    expect_in_order(keys);
    const double first = std::ceil(path.start_s() * fps);
    ASSERT_EQ(static_cast<double>(keys.translation.times_s.size()),
              std::ceil(end_s * fps) - first + 1);
    EXPECT_EQ(keys.enters_s, keys.translation.times_s.front());
    for (std::size_t i = 0; i < keys.translation.times_s.size(); ++i) {
      const double frame_s = (first + static_cast<double>(i)) / fps;
      EXPECT_EQ(keys.translation.times_s[i], static_cast<float>(frame_s));
      const auto pose = path.pose_at(frame_s);
      EXPECT_EQ(keys.translation.values[i], y_up(pose->centre_m));
    }
    EXPECT_EQ(keys.rotation.times_s, keys.translation.times_s);
  }
}

TEST(Keys, AreRefusedWhereTheyAreTooMany) {
  motion::Path path(0);
  path.append({.angular_velocity_radps = {1e6, 0, 0}});
  EXPECT_THAT(keys_of(path, 1000).error(), HasSubstr("maximum of 1000000"));
  path = motion::Path(0);
  path.append({.acceleration_mps2 = {1e9, 0, 0}});
  EXPECT_THAT(keys_of(path, 1e9).error(), HasSubstr("maximum of 1000000"));
  EXPECT_THAT(keys_of(path, 1e9, 24.0).error(), HasSubstr("maximum of 1000000"));
}

}  // namespace
}  // namespace sleight::gltf
