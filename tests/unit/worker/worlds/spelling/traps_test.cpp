#include "worker/worlds/spelling/traps.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <thread>

#include "common/random/distributions.h"
#include "tests/support/property.h"
#include "worker/physics/event/tolerances.h"
#include "worker/worlds/spelling/spelling.h"

namespace sleight::worlds::spelling::traps_test {

constexpr std::uint64_t k_seed = 20'260'511;
constexpr double k_radius_m = 0.008;

std::uint64_t animation_count() {
  return property::long_run() ? 100'000 : property::of_tier(150, 300);
}

random::Stream stream_of(std::uint64_t n) {
  return random::Stream({.seed = k_seed, .purpose = random::Purpose::prior}, n);
}

// ---- one ball -----------------------------------------------------------------------------------

/// A box of three by two bins with a ball in bin (1, 0). This bin has partitions in both
/// directions.
struct OneBall {
  WorldParameters world{};
  Bins bins{world, 3, 2};
  std::vector<Vec3> offsets_m = std::vector<Vec3>(bins.vertex_count(), Vec3::Zero());
  Bin bin{.column = 1, .row = 0};
  Vec3 centre_m = bins.floor_middle_m(bin) + Vec3(0, 0, world.dome_m + k_radius_m);
  physics::Twist twist{};

  std::optional<Traps::Place> place() const {
    return Traps(world, bins, offsets_m).of(centre_m, twist);
  }
};

bool box_holds(const physics::Box& box, const Vec3& centre_m) {
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    const double reach_m = k_radius_m + physics::k_touch_m;
    if (centre_m[i] - reach_m < double{box.low_m[axis]} ||
        centre_m[i] + reach_m > double{box.high_m[axis]})
      return false;
  }
  return true;
}

TEST(Traps, AWallThatIsLowerThanThePartitionsLetsBallsOut) {
  // Goal: a bin traps a ball only if the ball stays below the lowest wall around the bin. Method:
  // test two boxes. In one box, the walls are higher than the partitions; in the other box, they
  // are lower.
  OneBall ball;
  EXPECT_TRUE(ball.place());
  ball.world.box_height_m = 0.006;
  EXPECT_FALSE(ball.place());
}

TEST(Traps, ABallAtRestInABinIsTrappedThere) {
  // Goal: a ball at rest in a bin is trapped in that bin, and the trap's box contains the ball.
  // Method: put a ball on the floor of each bin, in the middle and towards two corners.
  for (std::uint32_t column = 0; column < 3; ++column) {
    for (std::uint32_t row = 0; row < 2; ++row) {
      OneBall ball;
      for (const double aside_m : {0.0, 0.002, -0.002}) {
        ball.centre_m =
            ball.bins.floor_middle_m({column, row}) + Vec3(aside_m, aside_m, k_radius_m + 0.0008);
        const auto place = ball.place();
        ASSERT_TRUE(place);
        EXPECT_EQ(place->bin, (Bin{column, row}));
        EXPECT_TRUE(box_holds(place->box, ball.centre_m));
      }
    }
  }
}

TEST(Traps, WhatMayRiseOverThePartitionsIsNot) {
  // Goal: a bin traps a ball only if the energy of motion and spin cannot lift the ball over the
  // partitions, in any direction. Method: test speeds around v^2 = 2 g 3 mm. At this speed, a ball
  // 3 mm below the partitions' height just reaches that height. The trap's margin is a tenth of a
  // millimetre.
  const double height_m = 0.003;
  const double speed_mps = std::sqrt(2 * 9.81 * height_m);
  const double less_mps = std::sqrt(2 * 9.81 * (height_m - 0.00015));
  for (const Vec3& way : {Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(0, 0, 1), Vec3(0, 0, -1)}) {
    OneBall ball;
    ball.twist.velocity_mps = less_mps * way;
    EXPECT_TRUE(ball.place());
    ball.twist.velocity_mps = speed_mps * way;
    EXPECT_FALSE(ball.place());
    // If a solid ball's surface speed equals its speed, its spin has 2/5 of the energy of its
    // motion.
    ball.twist.velocity_mps = Vec3::Zero();
    ball.twist.angular_velocity_radps = less_mps / k_radius_m / std::sqrt(0.4) * way;
    EXPECT_TRUE(ball.place());
    ball.twist.angular_velocity_radps *= speed_mps / less_mps;
    EXPECT_FALSE(ball.place());
    // Half of the energy is in motion, half in spin.
    ball.twist.angular_velocity_radps *= std::sqrt(0.5);
    ball.twist.velocity_mps = std::sqrt(0.5) * speed_mps * way;
    EXPECT_FALSE(ball.place());
  }
  OneBall ball;
  ball.centre_m.z() = 0.0118;
  EXPECT_TRUE(ball.place());
  ball.centre_m.z() = 0.012;
  EXPECT_FALSE(ball.place());
}

TEST(Traps, WhatIsOverAPartitionOrOutsideIsNot) {
  // Goal: a bin traps a ball only if the ball's centre is where the bin has room for a ball.
  OneBall ball;
  const Vec3 middle_m = ball.centre_m;
  for (const Vec3& way : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0)}) {
    ball.centre_m = middle_m + 0.00205 * way;
    EXPECT_TRUE(ball.place());
    ball.centre_m = middle_m + 0.0025 * way;
    EXPECT_FALSE(ball.place());
    ball.centre_m = middle_m + 0.011 * way;  // above the partition's middle
    EXPECT_FALSE(ball.place());
  }
  for (const Vec3& place_m : {Vec3(0.05, 0, 0.008), Vec3(0, -0.03, 0.008), Vec3(0, 0.011, -0.02),
                              Vec3(0, 0.011, -0.001)}) {
    ball.centre_m = place_m;
    EXPECT_FALSE(ball.place());
  }
}

TEST(Traps, LowerAndLeaningPartitionsHoldLess) {
  // Goal: among the corners around a bin, only the lowest corner limits which balls the bin traps.
  // Leaning partitions widen the trap's box, and partitions that lean too far trap no ball. The
  // corners of other bins have no effect. Method: lower each vertex of the box in turn. Also move
  // each vertex sideways, by a little and by a lot.
  OneBall ball;
  const auto& corners = ball.bins.corners(ball.bin);
  ASSERT_EQ(std::ranges::count(corners, k_no_vertex), 0);
  const physics::Box narrow = ball.place()->box;
  std::uint32_t own = 0;
  for (std::uint32_t v = 0; v < ball.bins.vertex_count(); ++v) {
    const bool is_own = std::ranges::count(corners, v) != 0;
    own += is_own ? 1 : 0;
    Vec3& offset_m = ball.offsets_m[v];
    offset_m = Vec3(0, 0, -0.0028);
    EXPECT_TRUE(ball.place());
    offset_m = Vec3(0, 0, -0.003);
    EXPECT_EQ(ball.place().has_value(), !is_own);
    offset_m = Vec3(0, 0, 0.003);
    EXPECT_TRUE(ball.place());
    for (const Vec3& way : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0)}) {
      offset_m = 0.0008 * way;
      const auto leaning = ball.place();
      ASSERT_TRUE(leaning);
      EXPECT_NEAR(leaning->box.high_m[0] - narrow.high_m[0], is_own ? 0.0008 : 0, 1e-7);
      EXPECT_NEAR(leaning->box.low_m[1] - narrow.low_m[1], is_own ? -0.0008 : 0, 1e-7);
      offset_m = 0.001 * way;
      EXPECT_EQ(ball.place().has_value(), !is_own);
    }
    offset_m = Vec3::Zero();
  }
  EXPECT_EQ(own, 4U);
  // Raised partitions don't trap higher balls, because the outcome uses the original height.
  for (Vec3& offset_m : ball.offsets_m)
    offset_m = Vec3(0, 0, 0.002);
  ball.centre_m.z() = 0.0125;
  EXPECT_FALSE(ball.place());
}

// ---- whole animations ---------------------------------------------------------------------------

/// Worlds of several sizes. In the last world, partitions lean strongly.
Parameters world_of(std::uint64_t kind) {
  Parameters parameters;
  switch (kind) {
    case 1:
      parameters.pattern = pattern_of_rows("#\n#\n").value();
      break;
    case 2:
      parameters.pattern = pattern_of_rows("#.#\n###\n#.#\n").value();
      break;
    case 3:
      parameters.pattern = centred(hi(), 15, 7);
      break;
    case 4:
      parameters.pattern = pattern_of_rows("###\n###\n###\n").value();
      parameters.world.vertex_sd_m = 0.0004;
      break;
    default:
      break;
  }
  return parameters;
}
constexpr std::uint64_t k_worlds = 5;

/// A draw from the prior. In half of the draws, all balls are active.
State random_state(const Spelling& world, std::uint64_t n) {
  random::Stream stream = stream_of(n);
  State state = world.draw_prior(stream);
  if (n / k_worlds % 2 == 0) return state;
  const Vec2& half_m = world.prior().drop_half_m;
  for (std::uint32_t ball = 0; ball < world.balls(); ++ball) {
    if (state.active[ball] != 0) continue;
    state.active[ball] = 1;
    state.drops_m[ball] = {random::Uniform{.low = -half_m.x(), .high = half_m.x()}.draw(stream),
                           random::Uniform{.low = -half_m.y(), .high = half_m.y()}.draw(stream)};
  }
  return state;
}

/// Bounds on a ball: the intersection of the boxes of all the ball's traps so far.
struct Hold {
  bool any = false;
  Bin bin;
  physics::Box box;

  void add(const Traps::Place& place) {
    if (!any) *this = {.any = true, .bin = place.bin, .box = place.box};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.low_m[axis] = std::max(box.low_m[axis], place.box.low_m[axis]);
      box.high_m[axis] = std::min(box.high_m[axis], place.box.high_m[axis]);
    }
  }
};

/// Follows a ball's recorded motion. Returns the number of segments in which the ball was trapped.
std::uint64_t expect_held(const Traps& traps, const Bins& bins,
                          std::span<const physics::Recording::Entry> entries, physics::Tick end,
                          random::Stream& stream) {
  std::uint64_t held = 0;
  Hold hold;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const auto& [segment, cause] = entries[i];
    const physics::FreeFlight& flight = segment.flight;
    const bool by_ball = cause.kind == physics::EventKind::collision && (cause.higher >> 31U) == 0;
    if (by_ball) hold.any = false;
    const auto place =
        traps.of(flight.position_m, {.velocity_mps = flight.velocity_mps,
                                     .angular_velocity_radps = flight.angular_velocity_radps});
    // A trapped ball stays trapped, because its energy grows only by rounding.
    if (hold.any && place) {
      EXPECT_EQ(place->bin, hold.bin);
    }
    if (place) hold.add(*place);
    if (!hold.any) continue;
    ++held;
    const physics::Tick until = i + 1 < entries.size() ? entries[i + 1].segment.flight.begin : end;
    const auto top = physics::ticks_before(std::max(0.0, flight.velocity_mps.z() / 9.81));
    const auto random = static_cast<physics::TickCount>(stream.uniform() *
                                                        static_cast<double>(until - flight.begin));
    for (const physics::Tick tick :
         {flight.begin, flight.begin + random, std::min(until, flight.begin + top), until}) {
      const Vec3 centre_m = physics::position_at(flight, tick);
      EXPECT_TRUE(box_holds(hold.box, centre_m)) << centre_m.transpose();
      EXPECT_EQ(bins.bin_at(centre_m), hold.bin);
    }
  }
  return held;
}

TEST(Traps, WhatIsTrappedStaysUntilAnotherBallComes) {
  // Goal: a trapped ball stays in its trap's box until it hits another ball. Method: in recorded
  // animations, check a trapped ball in each segment: at the beginning, at the end, at the highest
  // point and at a random time.
  std::uint64_t held = 0;
  const std::uint64_t animations = animation_count() / 5;
  for (const std::uint64_t n : property::cases(animations)) {
    const Spelling world(world_of(n % k_worlds));
    const State state = random_state(world, n);
    const auto scene = world.scene(state);
    if (!scene || scene->bodies.empty()) continue;
    auto started = physics::Simulation::start(*scene, {});
    if (!started) continue;
    physics::Simulation simulation = std::move(started).value();
    if (simulation.run_until(scene->bodies.back().start_tick + physics::ticks_after(3.0))) continue;
    const Traps traps(world.parameters().world, world.bins(), state.offsets_m);
    random::Stream stream = stream_of(n + animations);
    for (std::uint32_t body = 0; body < scene->bodies.size(); ++body) {
      held += expect_held(traps, world.bins(), simulation.recording().segments({body}),
                          simulation.now(), stream);
    }
    if (HasFailure()) return;
  }
  if (!property::all_cases()) return;
  EXPECT_GT(held, 100 * animations);
}

TEST(Traps, ABallBetweenAnEdgeAndAWallIsDecided) {
  // Goal: a ball comes to rest if friction pulls it from an edge to a wall, and the wall carries no
  // load. Method: count the events of one animation out of 100,000. The ball of this animation once
  // alternated between edge and wall 80,000 times in 25 microseconds.
  const Spelling world(world_of(4));
  const State state = random_state(world, 35'114);
  const Outcome early = world.simulate(state);
  const Outcome whole = world.simulate_to_rest(state);
  EXPECT_EQ(whole.end, End::settled);
  EXPECT_EQ(early.end, End::settled);
  EXPECT_EQ(early.filled, whole.filled);
  const auto scene = world.scene(state);
  ASSERT_TRUE(scene);
  physics::Simulation simulation = physics::Simulation::start(*scene, {}).value();
  ASSERT_FALSE(simulation.run_until(scene->bodies.back().start_tick + physics::ticks_after(0.5)));
  EXPECT_LT(simulation.counts().events(), 5'000U);
}

TEST(Traps, WhatIsDecidedEarlyIsWhatARunToRestFinds) {
  // Goal: an outcome that is decided early equals the outcome of a simulation to rest (spelling.h,
  // invariant 2). Method: simulate random states to the decision and to rest. One object simulates
  // all states of its world, as in a chain.
  std::vector<Spelling> worlds;
  for (std::uint64_t kind = 0; kind < k_worlds; ++kind)
    worlds.emplace_back(world_of(kind));
  std::map<End, std::uint64_t> ends;
  std::uint64_t filled = 0;
  std::uint64_t earlier = 0;
  for (const std::uint64_t n : property::cases(animation_count())) {
    const Spelling& world = worlds[n % k_worlds];
    const State state = random_state(world, n);
    const Outcome early = world.simulate(state);
    const Outcome whole = world.simulate_to_rest(state);
    const auto message = [&] {
      return ::testing::Message() << "seed " << k_seed << ", animation " << n << ", world "
                                  << n % k_worlds;
    };
    ASSERT_EQ(early.filled, whole.filled) << message();
    ASSERT_EQ(early.elsewhere, whole.elsewhere) << message();
    ASSERT_EQ(early.end, whole.end) << message();
    ASSERT_LE(early.end_s, whole.end_s) << message();
    ++ends[early.end];
    filled += early.filled;
    earlier += early.end_s < whole.end_s ? 1 : 0;
  }
  if (!property::all_cases()) return;
  std::printf("seed %llu: %llu settled, %llu at the limit, %llu impossible, %llu earlier\n",
              static_cast<unsigned long long>(k_seed),
              static_cast<unsigned long long>(ends[End::settled]),
              static_cast<unsigned long long>(ends[End::time_limit]),
              static_cast<unsigned long long>(ends[End::impossible]),
              static_cast<unsigned long long>(earlier));
  EXPECT_GT(ends[End::settled], animation_count() * 8 / 10);
  EXPECT_GT(filled, animation_count());
  EXPECT_GT(earlier, animation_count() / 2);
}

TEST(Traps, ThreadsSimulateAsOneDoes) {
  // Goal: several threads can simulate with one world at once. Each thread has its own box, and the
  // states that a box simulated before have no effect. Method: compare the outcomes of four threads
  // with outcomes for which each state gets a new world.
  constexpr std::uint64_t k_states = 48;
  constexpr std::uint64_t k_threads = 4;
  const Spelling world(world_of(2));
  std::vector<State> states;
  for (std::uint64_t n = 0; n < k_states; ++n)
    states.push_back(random_state(world, n));
  std::array<std::vector<Outcome>, k_threads> of_threads;
  std::vector<std::thread> threads;
  for (std::uint64_t t = 0; t < k_threads; ++t) {
    threads.emplace_back([&, t] {
      // Each thread begins at another state, so that boxes have different histories.
      for (std::uint64_t n = 0; n < k_states; ++n)
        of_threads[t].push_back(world.simulate(states[(n + 11 * t) % k_states]));
    });
  }
  for (std::thread& thread : threads)
    thread.join();
  for (std::uint64_t n = 0; n < k_states; ++n) {
    const Outcome expected = Spelling(world_of(2)).simulate(states[n]);
    for (std::uint64_t t = 0; t < k_threads; ++t) {
      const Outcome& outcome = of_threads[t][(n + k_states - 11 * t % k_states) % k_states];
      EXPECT_EQ(outcome.filled, expected.filled) << n;
      EXPECT_EQ(outcome.elsewhere, expected.elsewhere) << n;
      EXPECT_EQ(outcome.end_s, expected.end_s) << n;
      EXPECT_EQ(outcome.end, expected.end) << n;
    }
  }
}

}  // namespace sleight::worlds::spelling::traps_test
