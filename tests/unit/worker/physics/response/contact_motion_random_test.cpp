// Tests the invariants of contact_motion.h on random input.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/support/property.h"
#include "tests/unit/worker/physics/response/contact_walk.h"
#include "tests/unit/worker/physics/response/reference.h"

namespace sleight::physics {
namespace {

using math::cross;
using math::dot;
using math::norm;
using namespace response_reference;

/// Gravity presses a ball onto one, two or three faces, which may have any direction. Friction is
/// random, and speeds are 1e-7 to 10 m/s. Some balls rest, and some roll on one face.
Trial random_trial(Dice& dice) {
  for (;;) {
    Trial trial;
    trial.body = {.radius_m = dice.spread(1e-3, 10), .gyration = dice.uniform(0.02, 0.67)};
    const double many = dice.uniform(0, 5);
    const std::size_t count = many < 2 ? 1 : many < 4.5 ? 2 : 3;
    const double c_max = dice.once_in(2) ? 0 : dice.spread(1e-4, 1);
    for (std::size_t i = 0; i < count; ++i) {
      trial.contacts.push_back({.normal = dice.direction(),
                                .friction = dice.once_in(8) ? 0 : dice.spread(1e-3, 2),
                                .rolling_friction = dice.uniform(0, 1) * c_max});
    }
    trial.gravity_mps2 = k_g * dice.direction();
    if (count == 2 && !is_valley(trial.contacts[0].normal, trial.contacts[1].normal)) continue;
    const double r = trial.body.radius_m;
    trial.twist = {(dice.once_in(6) ? 0 : dice.spread(1e-7, 10)) * dice.direction(),
                   (dice.once_in(6) ? 0 : dice.spread(1e-7, 10)) / r * dice.direction()};
    const Vec3& n = trial.contacts[0].normal;
    trial.twist.velocity_mps = along_faces(trial.contacts, trial.twist.velocity_mps);
    if (dice.once_in(4)) {
      Vec3& w = trial.twist.angular_velocity_radps;
      w = cross(n, trial.twist.velocity_mps) / r + dice.uniform(-1, 1) * dot(w, n) * n;
    }
    if (Walk(trial).holds()) return trial;
  }
}

double kinetic(const RoundBody& body, const Twist& twist) {
  const Vec3 turning = body.radius_m * twist.angular_velocity_radps;
  return 0.5 *
         (dot(twist.velocity_mps, twist.velocity_mps) + body.gyration * dot(turning, turning));
}

double speed_of(const RoundBody& body, const Twist& twist) {
  return norm(twist.velocity_mps) + body.radius_m * norm(twist.angular_velocity_radps);
}

/// Returns the friction that rolling needs minus the friction that the contacts allow, divided by
/// gravity. Uses Newton's and Euler's equations for one face or two faces.
double friction_missing(const Trial& trial, const ContactMotion& motion) {
  const RoundBody& body = trial.body;
  const Vec3 force = motion.acceleration_mps2 - trial.gravity_mps2;
  double worst = -1;
  if (trial.contacts.size() == 1) {
    const LastingContact& contact = trial.contacts[0];
    const double load = dot(force, contact.normal);
    worst = norm(force - load * contact.normal) - contact.friction * load;
  } else {
    // The force is the sum of the loads and of the friction along the line in which both faces
    // meet. Each contact exerts half of this friction.
    const Vec3 &a = trial.contacts[0].normal, &b = trial.contacts[1].normal;
    const Vec3 line = math::normalized(cross(a, b));
    const double along = dot(force, line);
    const double cosine = dot(a, b);
    const double load_a = (dot(force, a) - cosine * dot(force, b)) / (1 - cosine * cosine);
    const double load_b = (dot(force, b) - cosine * dot(force, a)) / (1 - cosine * cosine);
    EXPECT_LT(norm(force - load_a * a - load_b * b - along * line), 1e-9 * k_g);
    const Vec3 moment = body.gyration * body.radius_m * motion.angular_acceleration_radps2 +
                        0.5 * along * cross(a + b, line);
    // The remaining moment is rolling resistance, which opposes the spin.
    const Vec3& w = motion.start.angular_velocity_radps;
    const double most = (1 + body.gyration) * (trial.contacts[0].rolling_friction * load_a +
                                               trial.contacts[1].rolling_friction * load_b);
    EXPECT_LE(norm(moment), most + 1e-9 * k_g);
    EXPECT_LE(dot(moment, w), 1e-9 * k_g * norm(w));
    worst = std::max(std::fabs(0.5 * along) - trial.contacts[0].friction * load_a,
                     std::fabs(0.5 * along) - trial.contacts[1].friction * load_b);
  }
  return worst / k_g;
}

struct Worst {
  double value = -1;
  int at = -1;
  void offer(double other, int i) {
    if (!(other <= value)) *this = {other, i};
  }
};

struct Findings {
  Worst power;        ///< of all forces but gravity, relative to its terms
  Worst start;        ///< relative energy gain when a segment's start is corrected
  Worst velocity_in;  ///< along a normal, relative to the possible rounding
  Worst acceleration_in;
  Worst friction_missing;  ///< over gravity
  Worst instant;           ///< 1 if a segment had no duration
  std::array<Worst, 3> segments;
  std::array<int, 3> seen{};
  std::array<int, 3> left{};  ///< motions that left a face
  int rolled = 0;
};

int random_trials() {
  return static_cast<int>(property::of_tier(20'000, 100'000));
}
constexpr int k_segments_max = 1000;
constexpr double k_follow_s = 3600;

void judge(const Trial& trial, const ContactMotion& motion, const Twist& before, int i,
           const Walk& walk, Findings& found) {
  const RoundBody& body = trial.body;
  const double energy = kinetic(body, before);
  if (energy > 0) found.start.offer((kinetic(body, motion.start) - energy) / energy, i);

  // Loads in a flat or narrow valley are large, and so are their rounding errors.
  const bool valley = trial.contacts.size() == 2;
  const double sine = valley ? norm(cross(trial.contacts[0].normal, trial.contacts[1].normal)) : 1;

  // Power is linear in time, so test its sign at both ends. The last term allows for rounding: an
  // acceleration of 1e-15 g along a normal makes the loads do work.
  const Vec3 force = motion.acceleration_mps2 - trial.gravity_mps2;
  const Vec3 turning = body.radius_m * motion.angular_acceleration_radps2;
  for (const double s : {0.0, std::isinf(motion.lasts_s) ? 1 : motion.lasts_s}) {
    const Twist at = walk.twist_after(s);
    const double power = dot(force, at.velocity_mps) +
                         body.gyration * body.radius_m * dot(turning, at.angular_velocity_radps);
    const double scale = (norm(force) / sine + body.gyration * norm(turning)) *
                         (speed_of(body, at) + speed_of(body, before) + 1e-3 * k_g * s);
    if (scale > 0) found.power.offer(power / scale, i);
  }

  // Rounding tilts the direction of a nearly finished slip, but hardly changes the velocity.
  const double velocity_rounding = 1e-14 * speed_of(body, before) + 1e-300;
  const double acceleration_rounding =
      1e-12 * k_g / (sine * sine) + 1e-14 * speed_of(body, before) / motion.lasts_s;
  for (const LastingContact& contact : trial.contacts) {
    found.velocity_in.offer(
        std::fabs(dot(motion.start.velocity_mps, contact.normal)) / velocity_rounding, i);
    found.acceleration_in.offer(
        std::fabs(dot(motion.acceleration_mps2, contact.normal)) / acceleration_rounding, i);
  }
  if (motion.rolls && trial.contacts.size() < 3) {
    ++found.rolled;
    found.friction_missing.offer(friction_missing(trial, motion), i);
  }
}

/// Results of random trials. Each trial was followed to its end or for an hour.
const Findings& findings() {
  static const Findings result = [] {
    Findings found;
    Dice dice(51);
    for (int i = 0; i < random_trials(); ++i) {
      const Trial trial = random_trial(dice);
      const std::size_t kind = trial.contacts.size() - 1;
      ++found.seen[kind];
      Walk walk(trial);
      Twist before = trial.twist;
      for (;; walk.next()) {
        if (!walk.holds()) {
          ++found.left[kind];
          break;
        }
        if (!(walk.motion().lasts_s > 0)) found.instant.offer(1, i);
        judge(trial, walk.motion(), before, i, walk, found);
        if (walk.is_last() || walk.begin_s() > k_follow_s || walk.segments() >= k_segments_max)
          break;
        before = walk.twist_after(walk.lasts_s());
      }
      found.segments[kind].offer(walk.segments(), i);
    }
    return found;
  }();
  return result;
}

void expect_at_most(const char* what, const Worst& worst, double most) {
  std::printf("seed 51: %s %.2e at most, in case %d\n", what, worst.value, worst.at);
  EXPECT_LE(worst.value, most) << what << ", seed 51, case " << worst.at;
}

TEST(ContactMotionAtRandom, GainsNoEnergy) {
  // Goal: motions gain no energy (contact_motion.h, invariant 1). Method: in all segments of random
  // trials, test the power of friction and resistance at both ends. Also test the energy change
  // when a segment's start is corrected.
  expect_at_most("power over its terms", findings().power, 1e-12);
  expect_at_most("relative gain at starts", findings().start, 1e-13);
}

TEST(ContactMotionAtRandom, StaysOnItsFaces) {
  // Goal: balls stay on their faces (contact_motion.h, invariant 2). Method: compute the velocity
  // and acceleration along the faces' normals in random trials.
  expect_at_most("velocity along a normal over rounding", findings().velocity_in, 1);
  expect_at_most("acceleration along a normal over rounding", findings().acceleration_in, 1);
}

TEST(ContactMotionAtRandom, RollsOnlyOnFrictionThatItHas) {
  // Goal: a rolling ball needs no more friction at a contact than mu times the load. Method:
  // compute the friction from Newton's and Euler's equations in random trials.
  EXPECT_GT(findings().rolled, random_trials() / 10);
  expect_at_most("friction missing, over gravity", findings().friction_missing, 1e-12);
}

TEST(ContactMotionAtRandom, BecomesSteady) {
  // Goal: within a bounded number of segments, every motion rolls, rests, slides straight, leaves a
  // face or lasts an hour. Method: count the segments of random trials. No segment may have zero
  // duration.
  const Findings& found = findings();
  expect_at_most("segments without duration", found.instant, 0);
  for (std::size_t kind = 0; kind < 3; ++kind) {
    std::printf("%zu faces: %d cases, %d left a face\n", kind + 1, found.seen[kind],
                found.left[kind]);
    EXPECT_GT(found.seen[kind], random_trials() / 100);
    expect_at_most("segments", found.segments[kind], 512);
  }
}

TEST(ContactMotion, HopsKeepEnergy) {
  // Goal: a hop keeps the kinetic energy and takes at most half of the energy of sliding and spin.
  // If that energy suffices, the hop reaches the requested speed. A rolling ball still rolls after
  // a hop. Method: test random balls that don't approach the face. Their speeds have all
  // magnitudes.
  const std::uint64_t seed = 52;
  Dice dice(seed);
  double worst = 0;
  int rich = 0;
  int poor = 0;
  for ([[maybe_unused]] const std::uint64_t i : property::in_turn(100'000)) {
    if (HasFailure()) break;
    const RoundBody body{.radius_m = dice.spread(1e-3, 10), .gyration = dice.uniform(0.02, 0.67)};
    const Vec3 n = dice.direction();
    const Vec3 across = dice.direction();
    const double rising_mps = dice.once_in(3) ? 0 : dice.spread(1e-6, 1);
    Twist twist{dice.spread(1e-6, 10) * (across - dot(across, n) * n) + rising_mps * n,
                dice.spread(1e-6, 10) / body.radius_m * dice.direction()};
    if (dice.once_in(3))
      twist.angular_velocity_radps = cross(n, twist.velocity_mps) / body.radius_m;
    const double speed_mps = dice.spread(1e-5, 1);
    const Twist out = hop(body, n, twist, speed_mps);
    const double energy = kinetic(body, twist);
    worst = std::max(worst, std::fabs(kinetic(body, out) - energy) / energy);
    ASSERT_LE(std::fabs(kinetic(body, out) - energy), 1e-14 * energy);

    const auto rising = [&](const Twist& of) { return dot(of.velocity_mps, n); };
    const auto purse = [&](const Twist& of) {
      return kinetic(body, of) - 0.5 * rising(of) * rising(of);
    };
    ASSERT_GE(purse(out), 0.5 * purse(twist) - 1e-14 * energy);
    const double before_mps = std::max(0.0, rising(twist));
    const double scale_mps = std::sqrt(2 * energy);
    if (before_mps >= speed_mps) {
      ASSERT_EQ(out.velocity_mps, twist.velocity_mps);
      ASSERT_EQ(out.angular_velocity_radps, twist.angular_velocity_radps);
      continue;
    }
    const double wanted = speed_mps * speed_mps - before_mps * before_mps;
    const double paid = std::min(wanted, purse(twist));
    ++(wanted < purse(twist) ? rich : poor);
    ASSERT_NEAR(rising(out), std::sqrt(before_mps * before_mps + paid), 1e-13 * scale_mps);
    // Sliding and spin shrink by the same factor, so a slip of 0 stays 0.
    const Vec3 along = twist.velocity_mps - rising(twist) * n;
    const double share = std::sqrt(1 - paid / (2 * purse(twist)));
    ASSERT_LE(norm(out.velocity_mps - rising(out) * n - share * along), 1e-13 * scale_mps);
    ASSERT_LE(
        body.radius_m * norm(out.angular_velocity_radps - share * twist.angular_velocity_radps),
        1e-13 * scale_mps);
  }
  std::printf("seed 52: energy to %.1e\n", worst);
  if (!property::all_cases()) return;
  EXPECT_GT(rich, 10'000);
  EXPECT_GT(poor, 10'000);
}

}  // namespace
}  // namespace sleight::physics
