// Compares the simulator's closed-form hops with a ball that moves in small time steps.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/property.h"
#include "tests/unit/worker/worlds/ball_2d/support.h"

namespace sleight::worlds::ball_2d {
namespace {

/// A ball that moves in fixed time steps. If the centre is below the table after a step, bisection
/// of the step finds the time of the collision. Velocities change in the frame of the tilted
/// surface. The class shares the world's parameters with the simulator, but no code.
class SteppedBall {
 public:
  SteppedBall(const WorldParameters& world, double step_s) : world_(world), step_s_(step_s) {
    z_m_ = world.drop_height_diameters * world.diameter_m;
  }

  void collide(double tilt_rad) {
    // The velocity's component along the surface stays. The component along the normal reverses and
    // shrinks.
    const double along = vx_ * std::cos(tilt_rad) - vz_ * std::sin(tilt_rad);
    double away = vx_ * std::sin(tilt_rad) + vz_ * std::cos(tilt_rad);
    if (away < 0) away = -world_.restitution * away;
    vx_ = along * std::cos(tilt_rad) + away * std::sin(tilt_rad);
    vz_ = -along * std::sin(tilt_rad) + away * std::cos(tilt_rad);
  }

  /// Steps until the ball reaches the table again. Does nothing if the ball doesn't rise from the
  /// table.
  void fly() {
    if (z_m_ <= 0 && vz_ <= 0) return;
    while (true) {
      const SteppedBall before = *this;
      advance(step_s_);
      if (z_m_ >= 0 || vz_ >= 0) continue;
      double low_s = 0;
      double high_s = step_s_;
      for (int i = 0; i < 60; ++i) {
        const double middle_s = (low_s + high_s) / 2;
        *this = before;
        advance(middle_s);
        (z_m_ >= 0 || vz_ >= 0 ? low_s : high_s) = middle_s;
      }
      z_m_ = 0;
      return;
    }
  }

  double x_m() const { return x_m_; }
  double time_s() const { return time_s_; }

 private:
  /// Velocity Verlet, which is exact for constant acceleration.
  void advance(double seconds) {
    x_m_ += vx_ * seconds;
    z_m_ += vz_ * seconds - 0.5 * world_.gravity_mps2 * seconds * seconds;
    vz_ -= world_.gravity_mps2 * seconds;
    time_s_ += seconds;
  }

  WorldParameters world_;
  double step_s_;
  double x_m_ = 0;
  double z_m_;
  double vx_ = 0;
  double vz_ = 0;
  double time_s_ = 0;
};

TEST(MotionOracle, HopsAreThoseOfASteppedBall) {
  // Goal: the simulation follows the model of thesis section 2.4.1. Method: compare the landing
  // with the landing of a ball that moves in time steps. A step is a hundredth of the fall's time.
  // Use random worlds and random normals. Some normals are tilted by more than 90 degrees.
  constexpr std::uint64_t k_seed = 31;
  std::uint64_t moved = 0;
  for (const std::uint64_t index : property::cases(300)) {
    random::Stream stream = testing::stream_of(k_seed, index);
    const WorldParameters world = testing::random_world(stream);
    const double sd_rad = (index % 3 == 0 ? 60 : 10) * testing::k_degree_rad;
    const NormalAngles normals = testing::random_normals(world, sd_rad, stream);
    const double fall_s = testing::impact_speed(world) / world.gravity_mps2;

    SteppedBall ball(world, fall_s / 100);
    ball.fly();
    for (std::uint32_t i = 0; i < world.collisions; ++i) {
      ball.collide(normals[i]);
      ball.fly();
    }
    const Landing landing = simulate_landing(world, normals);
    const double size_m = world.drop_height_diameters * world.diameter_m;
    // Times are accurate to 1e-13 of the time between bounces. Grazing collisions magnify the
    // error.
    EXPECT_NEAR(landing.x_m, ball.x_m(), 1e-8 * size_m);
    EXPECT_NEAR(landing.time_s, ball.time_s(), 1e-8 * fall_s);
    if (std::abs(landing.x_m) > 0.01 * size_m) ++moved;
    if (HasFailure()) return;
  }
  if (!property::all_cases()) return;
  EXPECT_GT(moved, 200U);
}

}  // namespace
}  // namespace sleight::worlds::ball_2d
