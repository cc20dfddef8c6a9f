// Tests that the spelling world's own engine gives the simulator's results.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <memory>

#include "tests/support/property.h"
#include "tests/unit/worker/physics/marbles/same_balls.h"
#include "tests/unit/worker/worlds/spelling/full_pattern.h"
#include "worker/physics/simulator/simulation.h"
#include "worker/worlds/spelling/spelling.h"
#include "worker/worlds/spelling/traps.h"

namespace sleight::worlds::spelling {
namespace {

using physics::Tick;
using physics::ticks_after;

std::uint64_t state_count() {
  return property::long_run() ? 100'000 : property::of_tier(100, 300);
}

/// A prior draw. In two of three draws, all balls are active.
State draw(const Spelling& world, std::uint64_t seed) {
  random::Stream stream({.seed = 11, .purpose = random::Purpose::prior}, seed);
  State state = world.draw_prior(stream);
  for (std::size_t ball = 0; ball < state.active.size() && seed % 3 != 0; ++ball) {
    if (state.active[ball] != 0) continue;
    state.active[ball] = 1;
    const double x = (2 * stream.uniform() - 1) * world.prior().drop_half_m.x();
    const double y = (2 * stream.uniform() - 1) * world.prior().drop_half_m.y();
    state.drops_m[ball] = {x, y};
  }
  return state;
}

/// Compares both engines and the world's outcome for a state.
void expect_alike(const Spelling& world, const State& state, bool to_rest) {
  const auto scene = world.scene(state);
  const Outcome outcome = to_rest ? world.simulate_to_rest(state) : world.simulate(state);
  ASSERT_EQ(outcome.end == End::impossible && !scene, !scene);
  if (!scene || scene->bodies.empty()) return;
  const Traps traps(world.parameters().world, world.bins(), state.offsets_m);
  physics::SimulationOptions options;
  options.record = false;
  const physics::StaticGeometry statics(*scene);
  auto started = physics::Simulation::start(*scene, options);
  const physics::NearFeatures near(statics, 0.5 * world.parameters().world.ball_diameter_m);
  const Tick last = scene->bodies.back().start_tick;
  const Tick limit = last + ticks_after(world.parameters().world.time_limit_s);
  physics::MarbleConfinement confinement;
  if (!to_rest) {
    confinement = [&](physics::BodyId, const Vec3& centre_m, const physics::Twist& twist) {
      const auto place = traps.of(centre_m, twist);
      return place ? std::optional(place->box) : std::nullopt;
    };
  }
  physics::Marbles marbles;
  marbles.start(*scene, near, limit, confinement);
  ASSERT_EQ(started.ok(), !marbles.run_until(Tick{}));
  if (!started) return;
  physics::Simulation simulation = std::move(started).value();
  bool goes_on = true;
  for (Tick early{}; early < last && goes_on; early = early + ticks_after(0.07))
    ASSERT_TRUE(physics::testing::alike_at(simulation, marbles, early, goes_on));
  bool all_stay = false;
  std::vector<Traps::Ball> balls(scene->bodies.size());
  for (Tick look = last; look < limit && goes_on && !all_stay;) {
    look = std::min(limit, look + ticks_after(0.1));
    ASSERT_TRUE(physics::testing::alike_at(simulation, marbles, look, goes_on));
    if (!goes_on) break;
    bool all_rest = true;
    for (std::uint32_t i = 0; i < balls.size(); ++i) {
      balls[i] = {.centre_m = simulation.pose({i}, look).position_m,
                  .twist = simulation.twist({i}, look),
                  .rests = simulation.mode({i}) == physics::MotionMode::resting};
      all_rest = all_rest && balls[i].rests;
    }
    all_stay = to_rest ? all_rest : traps.all_stay(balls);
  }
  EXPECT_EQ(outcome.is_animation(), goes_on);
  if (!goes_on) return;
  // The world's outcome uses the same places at the same times.
  std::vector<Spelling::Staying> staying;
  for (std::uint32_t i = 0; i < balls.size(); ++i) {
    if (balls[i].rests || traps.of(balls[i].centre_m, balls[i].twist))
      staying.push_back({.ball = i, .centre_m = balls[i].centre_m});
  }
  const Outcome expected =
      world.judged(staying, static_cast<std::uint32_t>(balls.size() - staying.size()));
  EXPECT_EQ(outcome.filled, expected.filled);
  EXPECT_EQ(outcome.elsewhere, expected.elsewhere);
  EXPECT_EQ(outcome.end_s, physics::seconds(simulation.now() - Tick{}));
  EXPECT_EQ(outcome.end == End::settled, staying.size() == balls.size());
}

void expect_all_alike(const Pattern& pattern, std::uint64_t states) {
  Parameters parameters;
  parameters.pattern = pattern;
  const Spelling world(parameters);
  for (const std::uint64_t seed : property::cases(states)) {
    expect_alike(world, draw(world, seed), seed % 2 == 0);
    if (::testing::Test::HasFailure()) return;
  }
}

TEST(SpellingMarbles, EqualASimulation) {
  // Goal: the world's engine gives the simulator's places, twists and modes bit for bit, whether or
  // not it suspends trapped balls. The world's outcome follows from these results. Method: compare
  // random states with complete simulations. The world reuses its geometry and moves it for each
  // state, but the simulations build new geometry.
  expect_all_alike(hi(), state_count());
}

TEST(SpellingMarbles, EqualASimulationOnSmallGrids) {
  // Goal: both engines agree on small grids, on which most bins are at a wall.
  expect_all_alike(full_pattern(1, 2), state_count());
  expect_all_alike(full_pattern(3, 3), state_count() / 3);
}

TEST(SpellingMarbles, EqualASimulationOnALargeGrid) {
  // Goal: both engines agree on many balls, on a grid that is as large as the grid of ACM.
  expect_all_alike(full_pattern(15, 7), state_count() / 50);
}

/// A world that a request can describe. Sizes, shapes, materials and thresholds of slow contacts
/// are random.
Parameters any_world(random::Stream& stream) {
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * stream.uniform();
  };
  Parameters parameters;
  const auto columns = static_cast<std::uint32_t>(uniform(1, 5));
  const auto rows = static_cast<std::uint32_t>(uniform(2, 4));
  parameters.pattern = full_pattern(columns, rows);
  WorldParameters& world = parameters.world;
  const double scale = stream.uniform() < 0.5 ? uniform(0.1, 1) : uniform(1, 10);
  world.bin_m = 0.02 * scale;
  world.partition_m = world.bin_m * uniform(0.02, 0.3);
  world.ball_diameter_m = world.bin_m * uniform(0.5, 0.9);
  world.partition_height_m = world.bin_m * uniform(0.7, 1);
  world.dome_m = stream.uniform() < 0.3 ? 1e-6 : world.bin_m * uniform(0, 0.2);
  world.vertex_sd_m = 0.1 * world.partition_m * uniform(0.01, 1);
  world.box_height_m = world.bin_m * uniform(1, 3);
  world.drop_height_m =
      world.partition_height_m + 10 * world.vertex_sd_m + world.bin_m * uniform(0.1, 3);
  world.drop_interval_s = 0.15 * std::sqrt(scale) * uniform(0.5, 2);
  world.restitution = uniform(0, 0.9);
  world.friction = uniform(0, 1);
  world.bounce_end = uniform(0.01, 0.1);
  world.rest_speed = world.bounce_end * uniform(2, 4);
  world.rest_time = world.bounce_end * uniform(2, 10);
  return parameters;
}

TEST(SpellingMarbles, EqualASimulationInAnyWorld) {
  // Goal: both engines agree in any valid world, and all simulations end. Method: in each of many
  // random worlds, compare two states.
  random::Stream stream({.seed = 12, .purpose = random::Purpose::scene}, 0);
  const std::uint64_t worlds = state_count() / 10;
  for (const std::uint64_t n : property::in_turn(worlds)) {
    const Spelling world(any_world(stream));
    for (std::uint64_t seed = 0; seed < 2; ++seed)
      expect_alike(world, draw(world, 2 * n + seed), seed == 0);
    if (::testing::Test::HasFailure()) return;
  }
}

}  // namespace
}  // namespace sleight::worlds::spelling
