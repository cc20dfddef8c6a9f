#include "worker/worlds/readers/readers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/unit/worker/worlds/readers/played.h"
#include "worker/worlds/segments/recorded_segments.h"
#include "worker/worlds/spelling/spelling.h"

namespace sleight::worlds::spelling {
namespace {

State state_of(const Spelling& world, std::uint64_t number) {
  random::Stream stream({.seed = 12, .purpose = random::Purpose::prior}, number);
  return world.draw_prior(stream);
}

TEST(SpellingReader, StatesComeBackFromTheirBytes) {
  // Goal: decode(encode(state)) returns the state, and decode() refuses bytes that are not an
  // encoded state. Method: cut, lengthen and damage the bytes of prior draws.
  const Spelling world(Parameters{});
  for (std::uint64_t number = 0; number < 50; ++number) {
    const State state = state_of(world, number);
    base::Bytes bytes = encode(state);
    const auto decoded = decode(world.prior(), bytes);
    ASSERT_TRUE(decoded.has_value());
    EXPECT_EQ(*decoded, state);
    base::Bytes longer = bytes;
    longer.push_back(std::byte{0});
    EXPECT_FALSE(decode(world.prior(), longer));
    base::Bytes shorter(bytes.begin(), bytes.end() - 1);
    EXPECT_FALSE(decode(world.prior(), shorter));
    State bad = state;
    bad.offsets_m[3].y() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(decode(world.prior(), encode(bad)));
    bad = state;
    bad.active[2] = 2;
    EXPECT_FALSE(decode(world.prior(), encode(bad)));
  }
}

TEST(SpellingReader, NamesFitValues) {
  // Goal: the numbers of values and outcomes match the layout. A ball's first recorded segment is
  // its drop, and in its last segment it rests.
  Parameters parameters;
  parameters.pattern = pattern_of_rows("#.#").value();
  const Spelling world(parameters);
  const auto reader = make_state_reader(parameters);
  std::size_t named = 0;
  for (const archive::Variable& variable : reader->layout().variables)
    named += variable.size();
  State state = state_of(world, 0);
  for (std::uint64_t number = 1; !world.satisfied(world.simulate(state)); ++number)
    state = state_of(world, number);
  const base::Bytes bytes = encode(state);
  EXPECT_EQ(reader->variables(bytes).size(), named);
  EXPECT_EQ(reader->layout().proposal_kinds.size(), k_kinds);
  worlds::testing::check_prior_draws(*reader);
  const motion::Animation motion = worlds::testing::played(*reader, bytes);
  std::uint32_t balls = 0;
  for (const motion::Path& path : motion.paths()) {
    EXPECT_EQ(path.enters(), state.active[path.body()] == 1);
    if (!path.enters()) continue;
    ++balls;
    EXPECT_NEAR(path.start_s(), 0.15 * path.body(), 1e-8);
    EXPECT_NEAR(path.segments().front().position_m.z(), 0.080, 1e-12);
    EXPECT_EQ(path.segments().back().mode, motion::Mode::resting);
  }
  EXPECT_EQ(balls, state.active_count());
  EXPECT_EQ(world.outcome_values(world.simulate(state)).size(), reader->layout().outcomes.size());
}

TEST(SpellingReader, MotionsAreTheSimulators) {
  // Goal: an archive's motion equals the simulator's motion at any time, and each hit names the
  // right ball. Method: compare poses at random times of throws into HI. At each hit of two balls,
  // their centres must be one diameter apart.
  const Parameters parameters;
  const Spelling world(parameters);
  const double radius_m = 0.5 * parameters.world.ball_diameter_m;
  random::Stream stream({.seed = 31, .purpose = random::Purpose::prior}, 0);
  int hits_of_balls = 0;
  for (std::uint64_t number = 0; number < 12; ++number) {
    const State state = world.draw_throw(stream);
    if (!world.simulate_to_rest(state).is_animation()) continue;
    const Animation animation = world.animate(state);
    const auto scene = world.scene(state);
    ASSERT_TRUE(scene.has_value());
    std::vector<RecordedBody> bodies;
    for (const std::uint32_t ball : animation.balls)
      bodies.push_back({.feature = ball});
    const auto motion =
        motion::Animation::of(recorded_segments(animation.recording, bodies,
                                                [](std::uint32_t, std::uint32_t) { return 99; }),
                              world.balls());
    ASSERT_TRUE(motion.ok());
    for (std::uint32_t body = 0; body < animation.balls.size(); ++body) {
      const motion::Path& path = motion.value().path(animation.balls[body]);
      const auto entries = animation.recording.segments({body});
      for (int i = 0; i < 40; ++i) {
        const physics::Tick tick =
            entries.front().segment.flight.begin +
            physics::ticks_after(stream.uniform() * (path.rest_s() - path.start_s()));
        const physics::Segment* simulated = animation.recording.segment_at({body}, tick);
        const double t_s = physics::seconds(tick - physics::Tick{});
        const auto pose = path.pose_at(t_s);
        ASSERT_TRUE(simulated != nullptr && pose.has_value());
        EXPECT_LT(
            math::norm(math::Vec3(pose->centre_m - physics::position_at(simulated->flight, tick))),
            1e-9);
        const math::Quat turn = math::composed(
            pose->orientation,
            math::inverse(physics::orientation_of(*simulated, scene->bodies[body].inertia, tick)));
        EXPECT_LT(1 - std::fabs(turn.w()), 1e-11);
      }
      for (const motion::Segment& segment : path.segments()) {
        if (segment.cause != motion::Cause::hit || segment.partner == 99) continue;
        const auto other =
            std::ranges::find(animation.balls, static_cast<std::uint32_t>(segment.partner));
        ASSERT_NE(other, animation.balls.end());
        const auto id = static_cast<std::uint32_t>(other - animation.balls.begin());
        const physics::Tick tick = physics::Tick{} + physics::ticks_after(segment.start_s);
        const physics::Segment* partner = animation.recording.segment_at({id}, tick);
        ASSERT_NE(partner, nullptr);
        const math::Vec3 apart_m = segment.position_m - physics::position_at(partner->flight, tick);
        EXPECT_NEAR(math::norm(apart_m), 2 * radius_m, 1e-7);
        ++hits_of_balls;
      }
    }
  }
  EXPECT_GT(hits_of_balls, 10);
}

TEST(SpellingReader, TheSceneIsTheSimulators) {
  // Goal: the scene's bodies are the balls. All balls are interchangeable. Each static object of
  // the simulation has its name in the scene, and each bin to fill is a goal. The bins' vertices
  // include the state's offsets. Method: compare the scene of HI with the simulator's scene of one
  // state.
  const Parameters parameters;
  const Spelling world(parameters);
  const auto reader = make_state_reader(parameters);
  const scene::Scene& scene = reader->scene();
  EXPECT_EQ(scene.bodies(), world.balls());
  for (std::uint32_t body = 0; body < scene.bodies(); ++body)
    EXPECT_EQ(scene.features[body].twin_of, 0U);
  const State state = state_of(world, 3);
  const auto simulated = world.scene(state);
  ASSERT_TRUE(simulated.has_value());
  const auto bins = scene.find("bins");
  ASSERT_TRUE(bins.has_value());
  const auto part = std::ranges::find(scene.parts, *bins, &scene::Part::feature);
  ASSERT_NE(part, scene.parts.end());
  const physics::TriangleMesh& mesh = *simulated->meshes.at(0).mesh;
  ASSERT_EQ(part->triangles, mesh.triangles().size());
  for (std::uint32_t i = 0; i < part->triangles; ++i) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const scene::Vertex& vertex =
          scene.vertices.at(scene.triangles[part->first_triangle + i][corner]);
      math::Vec3 place_m = vertex.place_m;
      if (vertex.offset != scene::k_none)
        place_m += state.offsets_m.at(static_cast<std::size_t>(vertex.offset));
      EXPECT_LT(math::norm(math::Vec3(place_m - mesh.vertices_m()[mesh.triangles()[i][corner]])),
                1e-15);
    }
  }
  for (const physics::StaticConvex& wall : simulated->convexes)
    EXPECT_TRUE(scene.find(wall.name).has_value()) << wall.name;
  EXPECT_TRUE(scene.find("ground").has_value());
  EXPECT_EQ(std::ranges::count(scene.features, scene::FeatureKind::wanted, &scene::Feature::kind),
            static_cast<std::ptrdiff_t>(world.balls()));
}

TEST(SpellingReader, BiasedSamplesSaySo) {
  // Goal: archives of runs with the thesis's kernel contain a warning, and other archives don't.
  Parameters parameters;
  EXPECT_EQ(make_state_reader(parameters)->layout().warning, "");
  parameters.proposal.kernel = Kernel::thesis;
  EXPECT_EQ(make_state_reader(parameters)->layout().warning,
            "biased kernel: thesis (A.2.2 as printed)");
}

TEST(SpellingReader, LikenessIsADistance) {
  // Goal: the distance of two animations is symmetric and at most 1. If both animations are equal,
  // the distance is 0. For some pairs, the distance is positive.
  const Parameters parameters;
  const Spelling world(parameters);
  const auto reader = make_state_reader(parameters);
  double most = 0;
  for (std::uint64_t number = 0; number < 5; ++number) {
    const base::Bytes a = encode(state_of(world, number));
    const base::Bytes b = encode(state_of(world, number + 100));
    EXPECT_EQ(worlds::testing::distance_by(*reader, a, a), 0);
    EXPECT_EQ(worlds::testing::distance_by(*reader, a, b),
              worlds::testing::distance_by(*reader, b, a));
    EXPECT_LE(worlds::testing::distance_by(*reader, a, b), 1);
    most = std::max(most, worlds::testing::distance_by(*reader, a, b));
  }
  EXPECT_GT(most, 0);
}

TEST(SpellingReader, WedgedBallsDontPlayOut) {
  // Goal: the reader reports states that were decided early but whose balls never come to rest. The
  // reader plays states whose balls come to rest. Method: use balls that almost fill their bins.
  // Among the states that satisfy the request, some come to rest and some don't.
  Parameters parameters;
  parameters.pattern = pattern_of_rows("#.").value();
  parameters.world.ball_diameter_m = 0.01998;
  parameters.world.partition_height_m = 0.025;
  const Spelling world(parameters);
  const auto reader = make_state_reader(parameters);
  int plays = 0;
  int fails = 0;
  for (std::uint64_t draw = 0; draw < 4000 && (plays == 0 || fails == 0); ++draw) {
    random::Stream stream({.seed = 7, .purpose = random::Purpose::prior}, draw);
    const State state = world.draw_prior(stream);
    if (!world.satisfied(world.simulate(state))) continue;
    if (reader->play(world.encode(state)).ends == archive::PlaysOut::yes) {
      ++plays;
      EXPECT_GT(reader->play(world.encode(state)).segments.size(), 1U);
    } else {
      ++fails;
    }
  }
  EXPECT_GT(plays, 0);
  EXPECT_GT(fails, 0);
}

}  // namespace
}  // namespace sleight::worlds::spelling
