#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>

#include "common/math/vector.h"
#include "tests/support/property.h"
#include "tests/unit/worker/physics/scene/random_friction.h"
#include "tests/unit/worker/physics/simulator/recorded_run.h"

namespace sleight::physics::lane_test {

using testing::RecordedRun;

constexpr double k_g_mps2 = 9.81;

struct Ball {
  double radius_m = 0.1;
  double gyration = 0.4;  ///< k = I / (m r^2)
};

/// A ball slightly above the plane z = 0.
Scene lane(const Ball& ball, const Twist& twist, const std::vector<FrictionRectangle>& rectangles,
           double friction_elsewhere) {
  Scene scene;
  scene.gravity_mps2 = {0, 0, -k_g_mps2};
  scene.contacts = ContactTable(1, {.restitution = 0, .friction = friction_elsewhere});
  scene.slow = slow_contacts_of(2 * ball.radius_m, k_g_mps2);
  // Slip ends at a tenth of the separation speed, and this tenth must be below the tolerance.
  scene.slow.separation_speed_mps = 1e-5;
  scene.planes.push_back({.name = "lane",
                          .outside = {.normal = {0, 0, 1}, .offset_m = 0},
                          .friction_map = std::make_shared<const FrictionMap>(
                              FrictionMap::make({}, rectangles).value())});
  constexpr double k_mass_kg = 7;
  const double moment = ball.gyration * k_mass_kg * ball.radius_m * ball.radius_m;
  scene.bodies.push_back(
      {.name = "ball",
       .shape = Sphere{.radius_m = ball.radius_m},
       .inertia = {.mass_kg = k_mass_kg,
                   .principal_kgm2 = {moment, moment, moment},
                   .symmetry = InertiaSymmetry::spherical},
       .start = {.pose = {.position_m = {0, 0, ball.radius_m + 1.2e-7}}, .twist = twist}});
  return scene;
}

const Segment& segment_at(const RecordedRun& run, Tick tick) {
  const Segment* last = nullptr;
  for (const Recording::Entry& entry : run.recording.segments({0})) {
    if (entry.segment.flight.begin <= tick) last = &entry.segment;
  }
  return *last;
}

/// Integrates the motion of a ball that slides and rolls. Uses the fourth-order Runge-Kutta method.
/// Halves steps where friction or slip changes.
class SteppedBall {
 public:
  struct State {
    double x = 0, y = 0, vx = 0, vy = 0, wx = 0, wy = 0;
  };
  SteppedBall(const Ball& ball, std::vector<FrictionRectangle> rectangles, double elsewhere)
      : ball_(ball), rectangles_(std::move(rectangles)), elsewhere_(elsewhere) {}

  State after(State state, double span_s) const {
    constexpr double k_longest_s = 2e-5;
    double done_s = 0;
    while (done_s < span_s) {
      double step_s = std::min(k_longest_s, span_s - done_s);
      const double friction = friction_at(state);
      State next = stepped(state, friction, step_s);
      // Halve the step until friction and slip don't change within it.
      while (step_s > 1e-13 && (friction_at(next) != friction || ends(state, friction, step_s))) {
        step_s *= 0.5;
        next = stepped(state, friction, step_s);
      }
      if (ends(state, friction, step_s)) stop_slip(next);
      state = next;
      done_s += step_s;
    }
    return state;
  }

 private:
  struct Slip {
    double x, y;
  };
  Slip slip_of(const State& s) const {
    return {s.vx - ball_.radius_m * s.wy, s.vy + ball_.radius_m * s.wx};
  }
  static bool slides(const Slip& slip) { return std::hypot(slip.x, slip.y) > 1e-11; }
  /// Returns whether friction can end the slip within a step of `step_s`.
  bool ends(const State& s, double friction, double step_s) const {
    const Slip slip = slip_of(s);
    return slides(slip) &&
           std::hypot(slip.x, slip.y) <= step_s * friction * k_g_mps2 * (1 + 1 / ball_.gyration);
  }
  double friction_at(const State& s) const {
    double found = elsewhere_;
    for (const FrictionRectangle& r : rectangles_) {
      if (s.x >= r.u_min_m && s.x < r.u_max_m && s.y >= r.v_min_m && s.y < r.v_max_m)
        found = r.friction;
    }
    return found;
  }
  State rate(const State& s, double friction) const {
    const Slip slip = slip_of(s);
    State d{.x = s.vx, .y = s.vy};
    if (!slides(slip)) return d;
    const double speed = std::hypot(slip.x, slip.y);
    d.vx = -friction * k_g_mps2 * slip.x / speed;
    d.vy = -friction * k_g_mps2 * slip.y / speed;
    // Torque of the force at -r z, over k m r^2.
    d.wx = d.vy / (ball_.gyration * ball_.radius_m);
    d.wy = -d.vx / (ball_.gyration * ball_.radius_m);
    return d;
  }
  static State sum(const State& a, const State& d, double h) {
    return {a.x + h * d.x,   a.y + h * d.y,   a.vx + h * d.vx,
            a.vy + h * d.vy, a.wx + h * d.wx, a.wy + h * d.wy};
  }
  State stepped(const State& s, double friction, double h) const {
    const State a = rate(s, friction);
    const State b = rate(sum(s, a, h / 2), friction);
    const State c = rate(sum(s, b, h / 2), friction);
    const State d = rate(sum(s, c, h), friction);
    return sum(sum(sum(sum(s, a, h / 6), b, h / 3), c, h / 3), d, h / 6);
  }
  void stop_slip(State& s) const {
    const Slip slip = slip_of(s);
    const double share = ball_.gyration / (1 + ball_.gyration);
    s.vx -= share * slip.x;
    s.vy -= share * slip.y;
    s.wx -= (1 - share) * slip.y / ball_.radius_m;
    s.wy += (1 - share) * slip.x / ball_.radius_m;
  }

  Ball ball_;
  std::vector<FrictionRectangle> rectangles_;
  double elsewhere_;
};

TEST(Lane, BallsRunAsAnIntegrationSays) {
  // Goal: the place of a ball that slides over a friction map is right to 1e-6 m, even after the
  // ball crosses borders and begins to roll. Method: throw random balls over random maps. One
  // second and two seconds after the first slide begins, compare the balls' places with a
  // Runge-Kutta integration. Compare the final velocity with a closed form that holds for any map:
  // v = (v0 + k r w) / (1 + k).
  int borders = 0;
  for (const std::uint64_t n : property::cases(property::long_run() ? 200 : 60)) {
    random::Stream stream({.seed = 20'261'128, .purpose = random::Purpose::prior}, n);
    const Ball ball{.radius_m = scenes::between(stream, 0.05, 0.2),
                    .gyration = scenes::between(stream, 0.2, 0.6)};
    const auto rectangles = testing::random_rectangles(stream, static_cast<int>(2 + n), 3);
    const double elsewhere = 0.15;
    Twist twist{.velocity_mps = scenes::vector_between(stream, -3, 3),
                .angular_velocity_radps = scenes::vector_between(stream, -30, 30)};
    twist.velocity_mps.z() = 0;
    const RecordedRun run = testing::recorded(lane(ball, twist, rectangles, elsewhere), 4);
    ASSERT_EQ(run.error, "");
    const auto segments = run.recording.segments({0});
    ASSERT_GT(segments.size(), 2U);
    const Segment& slide = segments[1].segment;
    ASSERT_EQ(slide.mode, MotionMode::sliding) << n;
    for (const Recording::Entry& entry : segments)
      borders += entry.cause.kind == EventKind::mode ? 1 : 0;
    const FreeFlight& from = slide.flight;
    SteppedBall::State state{from.position_m.x(),
                             from.position_m.y(),
                             from.velocity_mps.x(),
                             from.velocity_mps.y(),
                             from.angular_velocity_radps.x(),
                             from.angular_velocity_radps.y()};
    const SteppedBall stepped(ball, rectangles, elsewhere);
    for (int second = 1; second <= 2; ++second) {
      state = stepped.after(state, 1);
      const Tick tick = from.begin + second * ticks_after(1);
      const Segment& segment = segment_at(run, tick);
      if (segment.mode == MotionMode::resting) break;
      const Vec3 place_m = testing::place_at(segment, tick);
      EXPECT_NEAR(place_m.x(), state.x, 1e-6) << n << " after " << second << " s";
      EXPECT_NEAR(place_m.y(), state.y, 1e-6) << n << " after " << second << " s";
      EXPECT_NEAR(place_m.z(), ball.radius_m, 2e-7);
    }
    // If the ball rolls at the end, its final velocity has a closed form.
    const Segment& last = segments.back().segment;
    if (last.mode != MotionMode::rolling) continue;
    const double r = ball.radius_m;
    const double k = ball.gyration;
    const Vec3 roll_mps(r * from.angular_velocity_radps.y(), -r * from.angular_velocity_radps.x(),
                        0);
    const Vec3 expected_mps = (from.velocity_mps + k * roll_mps) / (1 + k);
    EXPECT_LT(math::norm(last.flight.velocity_mps - expected_mps), 1e-9) << n;
  }
  if (property::all_cases()) {
    EXPECT_GT(borders, 300);
  }
}

TEST(Lane, AMapMustLieInItsPlane) {
  // Goal: if the axes of a friction map are not in the map's plane, the error names the plane.
  Scene scene = lane({}, {}, {}, 0.1);
  EXPECT_TRUE(Simulation::start(scene, {}).ok());
  scene.planes[0].outside.normal = Vec3(0.6, 0, 0.8);
  const auto started = Simulation::start(scene, {});
  ASSERT_FALSE(started.ok());
  EXPECT_THAT(started.error().message, ::testing::MatchesRegex("plane 'lane': .*axes.*friction.*"));
}

TEST(Lane, AnUphillBorderTakesABoundedNumberOfEvents) {
  // Goal: a spinning ball that climbs from rough to smooth ground returns to the border again and
  // again. The ball causes a bounded number of events and gains no energy. Method: start balls at
  // the border with several speeds, including 0.
  const double lean = 0.1;
  for (const double speed_mps : {0.0, 1e-6, 1e-3, 0.1}) {
    const Ball ball;
    Scene scene =
        lane(ball, {.velocity_mps = {speed_mps, 0, 0}, .angular_velocity_radps = {0, 60, 0}},
             {{.u_min_m = -10, .u_max_m = 0, .v_min_m = -1, .v_max_m = 1, .friction = 0.5},
              {.u_min_m = 0, .u_max_m = 10, .v_min_m = -1, .v_max_m = 1, .friction = 0.01}},
             0.3);
    scene.gravity_mps2 = k_g_mps2 * Vec3(-std::sin(lean), 0, -std::cos(lean));
    const RecordedRun run = testing::recorded(scene, 2);
    ASSERT_EQ(run.error, "");
    EXPECT_LT(run.counts.modes, 2'000'000U) << speed_mps;
    const auto segments = run.recording.segments({0});
    const FreeFlight& last = segments.back().segment.flight;
    const double rise = last.position_m.x() * std::sin(lean) * k_g_mps2;
    const double kinetic =
        0.5 * math::dot(last.velocity_mps, last.velocity_mps) +
        0.2 * 0.01 * math::dot(last.angular_velocity_radps, last.angular_velocity_radps);
    EXPECT_LT(kinetic + rise, 0.5 * speed_mps * speed_mps + 0.2 * 0.01 * 3600 + 1e-6) << speed_mps;
  }
}

}  // namespace sleight::physics::lane_test
