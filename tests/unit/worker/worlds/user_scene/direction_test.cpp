// Goal: a directed scene has the values and distances that its request describes, and replays have
// the same outcomes. Method: compare values with formulas, distances with motions in closed form,
// and replays with fresh simulations; search a tray of dice, and read the find.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/unit/worker/worlds/user_scene/read_scene.h"
#include "worker/physics/reuse/history.h"
#include "worker/worlds/readers/readers.h"
#include "worker/worlds/user_scene/scene_search.h"

namespace sleight::worlds::user_scene {
namespace {

constexpr double k_g = 9.81;

/// Two balls and an off-centre compound, all in free fall.
constexpr const char* k_bodies = R"(end_s = 2
[[world.material]]
name = "clay"
density_kgpm3 = 2000
restitution = 0
[[world.body]]
name = "ball"
radius_mm = 10
at_mm = [0, 0, 1000]
row = {count = 2, step_mm = [100, 0, 0]}
[[world.body]]
name = "club"
shape = "compound"
at_mm = [0, 500, 1000]
part = [{radius_mm = 10}, {radius_mm = 10, at_mm = [30, 0, 0]}]
[[world.body]]
name = "box"
shape = "box"
size_mm = [10, 20, 30]
at_mm = [0, 800, 1000]
)";

UserScene world_of(const std::string& text) {
  return UserScene(parameters_of(text));
}
UserScene bodies(const std::string& text) {
  return world_of(k_bodies + text);
}
std::string uncertain(const std::string& body, const std::string& quantity,
                      const std::string& keys) {
  return "[[world.uncertain]]\nbody = \"" + body + "\"\nquantity = \"" + quantity + "\"\n" + keys +
         "\n";
}

TEST(Quantities, EachDrawHasItsNumbers) {
  const UserScene world = bodies(
      uncertain("ball", "position_mm", "normal_sd = [2, 0, 1]") +
      uncertain("box", "orientation", "") + uncertain("ball 2", "presence", "probability = 0.25") +
      uncertain("ball", "velocity_mps", "within = [1, 1, 1]\nshared = true"));
  const Quantities& all = world.quantities();
  ASSERT_EQ(all.draws().size(), 5U);
  EXPECT_EQ(all.size(), 2 + 2 + 4 + 1 + 3U);
  EXPECT_EQ(all.value_names()[0], "ball position_mm: ball 1 x");
  EXPECT_EQ(all.value_names()[3], "ball position_mm: ball 2 x");
  EXPECT_EQ(all.value_names()[10], "ball 2 presence");
  EXPECT_EQ(all.value_names().back(), "ball velocity_mps z");
  // The density is that of eight standard normals.
  Numbers state(all.size(), 0.5);
  EXPECT_NEAR(all.log_density(state), -8 * (0.5 * std::log(2 * std::numbers::pi) + 0.125), 1e-12);
  const auto logs = all.log_densities(state);
  EXPECT_NEAR(logs[0] + logs[1], all.log_density(state), 1e-12);
  EXPECT_EQ(logs[2], 0);
}

TEST(Quantities, ValuesFollowTheFormulas) {
  const UserScene world =
      bodies(uncertain("ball 1", "position_mm", "normal_sd = [2, 0, 1]") +
             uncertain("ball 2", "start_s", "within = [0.5]") +
             uncertain("ball", "radius_mm", "normal_sd = [2]\nwithin = [1]\nshared = true") +
             uncertain("box", "velocity_mps", "choices = [1, 2, 3, 4, 5, 6]\nshares = [1, 3]") +
             uncertain("box", "turn_deg", "normal_sd = [0, 0, 90]"));
  const auto values = world.quantities().values({1, -2, 0.25, 0.999999, 0.2501, 1});
  const std::vector<double> expected{2, 0, 998, 0, 11, 4, 5, 6, 0, 0, 90};
  ASSERT_EQ(values.size(), expected.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    EXPECT_NEAR(values[i], expected[i], 1e-4) << i;
  // A truncated normal: the mean of u = 1/2 is the nominal value; quartiles of N(0, 2) in [-1, 1].
  const auto radius = [&](double u) {
    return world.quantities().values({0, 0, 0.5, u, 0.5, 0})[4] - 10;
  };
  const double inside = std::erf(0.5 / std::numbers::sqrt2);
  EXPECT_EQ(radius(0.5), 0);
  EXPECT_EQ(radius(0.25), -radius(0.75));
  EXPECT_NEAR(std::erf(radius(0.75) / 2 / std::numbers::sqrt2) / inside, 0.5, 1e-12);
}

TEST(Quantities, ChangeTheScene) {
  const UserScene world =
      bodies(uncertain("club", "turn_deg", "normal_sd = [0, 0, 90]") +
             uncertain("club", "spin_radps", "normal_sd = [0, 0, 1]") +
             uncertain("ball 1", "radius_mm", "normal_sd = [10]") +
             uncertain("box", "size_mm", "normal_sd = [0, 0, 30]") +
             uncertain("ball 2", "presence", "probability = 0.5") +
             "[[world.uncertain]]\nmaterial = \"clay\"\nquantity = \"density_kgpm3\"\n"
             "choices = [1000]\n"
             "[[world.uncertain]]\nmaterial = \"clay\"\nquantity = \"restitution\"\nnormal_sd = "
             "[1]\n");
  const physics::Scene scene = world.quantities().scene({1, 2, 1, 1, 0.6, 0.5, 0.25}).value();
  const std::vector<Object>& objects = world.parameters().built->objects;
  const auto body = [&](const std::string& name) {
    const auto at = std::ranges::find(objects, name, &Object::name);
    return scene.bodies[static_cast<std::size_t>(at - objects.begin())];
  };
  // The club's centre, 15 mm along its x, is turned to y, and moves by spin times arm.
  EXPECT_NEAR(body("club").start.pose.position_m.y(), 0.515, 1e-12);
  EXPECT_NEAR(body("club").start.twist.velocity_mps.x(), -2 * 0.015, 1e-12);
  EXPECT_NEAR(std::get<physics::Sphere>(body("ball 1").shape).radius_m, 0.02, 1e-12);
  // The density is half of the described one.
  EXPECT_NEAR(body("ball 1").inertia.mass_kg, 1000 * 4 / 3.0 * std::numbers::pi * 8e-6, 1e-9);
  EXPECT_NEAR(body("box").inertia.mass_kg, 1000 * 0.01 * 0.02 * 0.06, 1e-12);
  EXPECT_EQ(body("ball 2").start_tick, physics::k_tick_max);
  EXPECT_NEAR(scene.contacts.between({}, {}).restitution, 0.25, 1e-12);
  EXPECT_EQ(world.simulate({{1, 2, 1, 1, 0.6, 0.5, 0.25}}).end, End::settled);
}

TEST(UserScene, DrawsThatCantStartAreImpossible) {
  const auto expect_impossible = [](const UserScene& world, const State& state) {
    const Outcome outcome = world.simulate(state);
    EXPECT_EQ(outcome.end, End::impossible);
    EXPECT_EQ(outcome.failure, nullptr);
    EXPECT_FALSE(world.satisfied(outcome));
  };
  // The balls' centres are 100 mm apart.
  const UserScene growing = bodies(uncertain("ball 1", "radius_mm", "normal_sd = [40]"));
  EXPECT_EQ(growing.simulate({{1}}).end, End::settled);
  expect_impossible(growing, {{2.1}});
  // 0.01 mm by 1 km make no shape.
  const UserScene flat = bodies(uncertain("box", "size_mm", "normal_sd = [1000000, 1000000, 0]"));
  EXPECT_EQ(flat.simulate({{0, 0}}).end, End::settled);
  expect_impossible(flat, {{-1, 1}});
  const UserScene resting = world_of(R"(end_s = 2
[[world.body]]
name = "floor"
shape = "plane"
[[world.body]]
name = "box"
shape = "box"
size_mm = [10, 20, 30]
at_mm = [0, 0, 15]
rests = true
)" + uncertain("box", "position_mm", "normal_sd = [1, 0, 1]"));
  EXPECT_EQ(resting.simulate({{1, 0}}).end, End::settled);
  expect_impossible(resting, {{0, 1}});   // above the floor
  expect_impossible(resting, {{0, -1}});  // in the floor
}

// ---- constraints --------------------------------------------------------------------------------

/// The distances of a scene without uncertainty.
std::vector<double> distances_of(const UserScene& world) {
  const Outcome outcome = world.simulate({{}});
  EXPECT_TRUE(outcome.is_animation());
  return outcome.judgement.distances;
}

TEST(Judge, PlacesInFreeFall) {
  const UserScene world = bodies(R"(
[[world.region]]
name = "below"
low_mm = [-5, -5, 0]
high_mm = [5, 5, 500]
[[constraint.place]]
body = "ball 1"
at_mm = [0, 30, 1000]
at_s = 0.2
sigma_mm = 1
[[constraint.place]]
body = "ball 2"
at_mm = [100, 40]
at_s = 0.1
sigma_mm = 1
[[constraint.region]]
body = "ball 1"
region = "below"
at_s = 0.1
sigma_mm = 1
[[constraint.region]]
body = "ball 1"
region = "below"
whole = true
at_s = 0.1
sigma_mm = 1
[[constraint.region]]
bodies = ["box", "ball 2"]
any = true
region = "below"
at_s = 0.1
sigma_mm = 1
)");
  const auto d = distances_of(world);
  const auto fallen_m = [](double t) { return 0.5 * k_g * t * t; };
  // Constraints keep the order of their kinds: regions first.
  const double above_m = 0.5 - fallen_m(0.1);
  EXPECT_NEAR(d[0], above_m, 1e-8);
  EXPECT_NEAR(d[1], std::hypot(above_m + 0.01, 0.005 * std::sqrt(4.0)), 1e-3);
  EXPECT_NEAR(d[2], std::hypot(above_m, 0.095), 1e-8);
  EXPECT_NEAR(d[3], std::hypot(0.03, fallen_m(0.2)), 1e-8);
  EXPECT_NEAR(d[4], 0.04, 1e-8);
  EXPECT_NEAR(world.simulate({{}}).end_s, 0.2, 1e-8);
}

constexpr const char* k_floor = R"(end_s = 2
[[world.material]]
name = "steel"
restitution = 0.5
[[world.body]]
name = "floor"
shape = "plane"
[[world.body]]
name = "wall"
shape = "box"
size_mm = [10, 10, 10]
at_mm = [300, 0, 5]
static = true
[[world.body]]
name = "ball"
radius_mm = 10
at_mm = [0, 0, 1010]
row = {count = 2, step_mm = [100, 0, 0]}
)";

TEST(Judge, HitsOfABouncingBall) {
  const double first_s = std::sqrt(2 / k_g);
  const UserScene world = world_of(k_floor + std::string(R"(
[[constraint.event]]
name = "late"
body = "ball 1"
hits = "floor"
at_s = 0.5
sigma_s = 0.01
tolerance_s = 0.1
[[constraint.event]]
name = "second"
body = "ball 1"
hits = "floor"
nth = 2
frame = 21.6
frames_per_s = 24
sigma_s = 0.01
tolerance_s = 0.01
[[constraint.event]]
name = "fast"
body = "ball 1"
hits = "floor"
at_least_mps = 4.5
after_s = 0.2
sigma_s = 0.01
[[constraint.event]]
name = "on the beat"
body = "ball 1"
hits = "floor"
beats_s = [0.1, 0.45, 0.8]
sigma_s = 0.01
tolerance_s = 0.01
[[constraint.event]]
name = "missed"
body = "ball 1"
hits = "wall"
at_s = 0.4
sigma_s = 0.01
tolerance_s = 0.01
[[constraint.order]]
events = ["second", "late"]
sigma_s = 0.1
[[constraint.never]]
body = "ball 2"
hits = "floor"
)"));
  const auto d = distances_of(world);
  const double second_s = 2 * first_s;  // up and down again at half the speed
  EXPECT_NEAR(d[0], 0.5 - first_s, 1e-7);
  EXPECT_NEAR(d[1], std::fabs(21.6 / 24 - second_s), 1e-7);
  EXPECT_GT(d[2], 0.25);  // no hit is that fast, although the gap is 0
  EXPECT_LT(d[2], 0.26);
  EXPECT_NEAR(d[3], first_s - 0.45, 1e-7);
  // The wall's box begins 295 mm away, and 10 mm is the ball's radius; near_mm is 10.
  EXPECT_NEAR(d[4], 0.25 + 0.01 * (0.285 / 0.01), 0.01);
  EXPECT_NEAR(d[5], second_s - first_s, 1e-7);
  EXPECT_NEAR(d[6], 2 - first_s, 1e-7);
}

TEST(Judge, RegionsAroundStaticBodies) {
  const std::string region = "body = \"ball 1\"\nat_s = 0\nsigma_mm = 1\ntolerance_mm = 2000\n";
  const UserScene world = world_of(k_floor + std::string(R"(
[[world.body]]
name = "lying pole"
shape = "capsule"
radius_mm = 10
length_mm = 100
at_mm = [0, -300, 10]
turn_deg = [0, 90, 0]
static = true
[[world.body]]
name = "slab"
shape = "mesh"
points_mm = [[-20, 0, 0], [-20, 9, 0], [-40, 9, 5]]
triangles = [[0, 1, 2]]
[[constraint.region]]
region = "wall"
)") + region + "[[constraint.region]]\nregion = \"lying pole\"\n" +
                                   region + "[[constraint.region]]\nregion = \"slab\"\n" + region);
  const auto d = distances_of(world);  // from (0, 0, 1010) mm
  EXPECT_NEAR(d[0], std::hypot(0.295, 1), 1e-9);
  EXPECT_NEAR(d[1], std::hypot(0.29, 0.99), 1e-9);
  EXPECT_NEAR(d[2], std::hypot(0.02, 1.005), 1e-9);
}

TEST(Judge, BodiesAtRest) {
  const UserScene world = world_of(R"(end_s = 3
[[world.material]]
name = "wood"
rolling_friction = 0.1
[[world.body]]
name = "floor"
shape = "plane"
[[world.body]]
name = "plank"
shape = "box"
size_mm = [10, 60, 100]
at_mm = [0, 0, 50]
rests = true
group = "planks"
row = {count = 2, step_mm = [300, 0, 0]}
[[world.body]]
name = "ball"
radius_mm = 10
at_mm = [-100, 0, 80]
velocity_mps = [2, 0, 0]
[[world.region]]
name = "left"
low_mm = [-200, -200, 0]
high_mm = [200, 200, 200]
[[constraint.topples]]
body = "plank 1"
[[constraint.stands]]
body = "plank 2"
[[constraint.face]]
body = "plank 1"
axis = [-1, 0, 0]
[[constraint.count]]
group = "planks"
region = "left"
[[constraint.place]]
body = "plank 2"
at_mm = [300, 0]
sigma_mm = 1
)");
  const Outcome outcome = world.simulate({{}});
  EXPECT_EQ(outcome.end, End::settled);
  const auto& d = outcome.judgement.distances;
  constexpr double k_deg = std::numbers::pi / 180;
  // Places, faces, topples, stands, counts.
  EXPECT_NEAR(d[0], 0, 1e-9);
  EXPECT_LT(d[1], 1 * k_deg);  // plank 1 fell away from the ball, with its -x side up
  EXPECT_EQ(d[2], 0);          // it topples
  EXPECT_EQ(d[3], 0);          // plank 2 stands
  EXPECT_EQ(d[4], 1);          // and isn't in the region
  EXPECT_EQ(outcome.judgement.met, (std::vector<bool>{true, true, true, true, false}));
  EXPECT_FALSE(outcome.judgement.all_met);
  // Nobody rests yet at 0.1 s, except plank 2.
  Parameters hasty = world.parameters();
  hasty.scene.end_s = 0.1;
  const Outcome early = UserScene(hasty).simulate({{}});
  EXPECT_EQ(early.end, End::time_limit);
  EXPECT_EQ(early.judgement.met, (std::vector<bool>{true, false, false, true, false}));
  EXPECT_NEAR(world.log_constraint(outcome), -0.5 * std::pow(d[1] / (10 * k_deg), 2) - 2.5, 1e-9);
}

// ---- the world ----------------------------------------------------------------------------------

constexpr const char* k_tray = R"(end_s = 4
[[world.body]]
name = "floor"
shape = "plane"
[[world.body]]
name = "wall"
shape = "box"
size_mm = [10, 110, 40]
at_mm = [0, 0, 20]
static = true
ring = {count = 4, radius_mm = 55}
[[world.body]]
name = "die"
shape = "box"
size_mm = [16, 16, 16]
at_mm = [-20, -30, 60]
velocity_mps = [0.5, 0, 0]
row = {count = 3, step_mm = [0, 30, 0]}
[[world.uncertain]]
body = "die"
quantity = "position_mm"
normal_sd = [5, 2, 5]
[[world.uncertain]]
body = "die"
quantity = "orientation"
[[world.uncertain]]
body = "die"
quantity = "presence"
probability = 0.8
[[world.uncertain]]
body = "die 3"
quantity = "start_s"
within = [1]
[[constraint.face]]
body = "die"
up = 6
[[constraint.event]]
body = "die 1"
hits = "wall"
at_s = 0.2
sigma_s = 0.05
tolerance_s = 0.05
)";

constexpr const char* k_noise = R"(
[world.contact_noise]
above_mps = 0.05
tilt_sd_deg = 2
restitution_sd = 0.05
)";

void expect_equal_replays(const UserScene& world) {
  random::Stream stream({.seed = 5, .purpose = random::Purpose::search}, 0);
  State state = world.draw_prior(stream);
  Outcome outcome = world.simulate(state);
  int replays = 0;
  for (int i = 0; i < 150; ++i) {
    const auto proposal = world.propose(state, outcome, {}, stream);
    const Outcome fresh = world.simulate(proposal.candidate);
    Outcome again = world.simulate_from(proposal.candidate, state, outcome);
    ASSERT_EQ(again.end, fresh.end) << i;
    ASSERT_EQ(again.end_s, fresh.end_s) << i;
    ASSERT_EQ(again.collisions, fresh.collisions) << i;
    ASSERT_EQ(again.judgement.distances, fresh.judgement.distances) << i;
    ASSERT_EQ(again.judgement.met, fresh.judgement.met) << i;
    ASSERT_EQ(again.noised, fresh.noised) << i;
    replays += outcome.history && again.history ? 1 : 0;
    state = proposal.candidate;
    outcome = std::move(again);
  }
  EXPECT_GT(replays, 20);
}

TEST(UserScene, ReplaysHaveTheSameOutcome) {
  expect_equal_replays(world_of(k_tray));
  // Without events, simulations have histories but no recordings.
  const std::string tray = k_tray;
  expect_equal_replays(world_of(tray.substr(0, tray.find("[[constraint.event]]"))));
  expect_equal_replays(world_of(tray + k_noise));
}

TEST(UserScene, ATailKeepsWhatCameBeforeIt) {
  // Goal: a state with a fresh tail has the same impacts before it and others after it, a renewal
  // changes no impact, and overrides stay bounded by the impacts and the shots since.
  const UserScene world = world_of(k_tray + std::string(k_noise));
  random::Stream stream({.seed = 6, .purpose = random::Purpose::search}, 0);
  const State state = sampling::nth_prior_draw(world, 1);
  const Outcome outcome = world.simulate(state);
  ASSERT_GT(outcome.noised.size(), 10U);
  const physics::Tick from = outcome.noised[outcome.noised.size() / 2].tick;
  State other = state;
  other.noise = with_fresh_tail(state.noise, outcome.noised, from, stream);
  const Outcome changed = world.simulate_from(other, state, outcome);
  EXPECT_NE(changed.noised, outcome.noised);
  for (std::size_t i = 0; outcome.noised[i].tick <= from; ++i)
    EXPECT_EQ(changed.noised[i], outcome.noised[i]);
  State renewed = state;
  renewed.noise = with_fresh_tail(state.noise, outcome.noised, physics::k_never, stream);
  EXPECT_NE(renewed.noise.key, state.noise.key);
  EXPECT_EQ(renewed.noise.overrides.size(), outcome.noised.size());
  EXPECT_EQ(world.simulate(renewed).noised, outcome.noised);
  // It needs no simulation: the outcome keeps its history.
  State again = other;
  again.noise = with_fresh_tail(other.noise, changed.noised, physics::k_never, stream);
  EXPECT_TRUE(changed.history &&
              world.simulate_from(again, other, changed).history == changed.history);
  EXPECT_EQ(world.decode(world.encode(renewed)), renewed);
  std::swap(renewed.noise.overrides[0], renewed.noise.overrides[1]);
  EXPECT_FALSE(world.decode(world.encode(renewed)));
}

TEST(UserScene, SearchGoesFrontToBack) {
  // Goal: constraints with times are stages in their order, and the search meets hits at times that
  // a single draw rarely meets. Method: a ball must hit a plate three times on a beat.
  const UserScene world = world_of(R"(end_s = 2
region = [{name = "here", low_mm = [-200, -200, 0], high_mm = [200, 200, 400]}]
[world.contact_noise]
above_mps = 0.1
restitution_sd = 0.1
tilt_sd_deg = 0.5
[[world.material]]
name = "rubber"
restitution = 0.8
[[world.body]]
name = "plate"
shape = "plane"
[[world.body]]
name = "ball"
radius_mm = 10
at_mm = [0, 0, 331]
[[constraint.region]]
body = "ball"
region = "here"
at_s = 1.5
sigma_mm = 20
[[constraint.event]]
name = "third"
body = "ball"
hits = "plate"
nth = 3
at_s = 1.05
tolerance_s = 0.005
sigma_s = 0.005
window_s = 0.1
[[constraint.event]]
name = "second"
body = "ball"
hits = "plate"
nth = 2
at_s = 0.7
tolerance_s = 0.005
sigma_s = 0.005
window_s = 0.1
)");
  ASSERT_EQ(world.stages(), 3U);
  EXPECT_EQ(world.stage_name(0), "'second'");
  EXPECT_EQ(world.stage_name(1), "'third'");
  std::uint64_t blind = 0;
  for (std::uint64_t nth = 0; nth < 200; ++nth)
    blind += world.satisfied(world.simulate(sampling::nth_prior_draw(world, nth)));
  EXPECT_LT(blind, 20);
  const SceneSearch search = world.builder({});
  for (std::uint64_t n = 0; n < 10; ++n) {
    random::Stream stream({.seed = 8, .purpose = random::Purpose::search}, n);
    sampling::SearchEffort effort;
    const auto find = sampling::search(search, search.limits(), stream, effort);
    ASSERT_TRUE(find.has_value()) << n;
    EXPECT_TRUE(world.satisfied(world.simulate(find->state)));
    EXPECT_GE(find->outcome.noised.size(), 3U);
  }
}

TEST(UserScene, StatesHaveBytes) {
  const UserScene world = world_of(k_tray);
  const State state = sampling::nth_prior_draw(world, 3);
  const base::Bytes bytes = world.encode(state);
  EXPECT_EQ(world.decode(bytes), state);
  State wrong = state;
  wrong.numbers.back() = 1;  // a uniform
  EXPECT_FALSE(world.decode(world.encode(wrong)));
  wrong.numbers.back() = std::nan("");
  EXPECT_FALSE(world.decode(world.encode(wrong)));
  EXPECT_FALSE(world.decode(std::span(bytes).first(bytes.size() - 8)));
}

TEST(UserScene, SearchFindsAndTheReaderShowsIt) {
  const Parameters parameters = parameters_of(k_tray);
  const UserScene world(parameters);
  const SceneSearch search = world.builder({});
  random::Stream stream({.seed = 7, .purpose = random::Purpose::search}, 0);
  sampling::SearchEffort effort;
  const auto find = sampling::search(search, search.limits(), stream, effort);
  ASSERT_TRUE(find.has_value());
  EXPECT_TRUE(world.satisfied(world.simulate(find->state)));

  const auto reader = make_state_reader(parameters);
  const base::Bytes bytes = world.encode(find->state);
  const archive::WorldLayout& layout = reader->layout();
  ASSERT_EQ(layout.variables.size(), 2U);
  EXPECT_EQ(layout.variables[0].dims[0].names[0], "die position_mm: die 1 x");
  EXPECT_EQ(layout.variables[0].size() + layout.variables[1].size(),
            reader->variables(bytes).size());
  EXPECT_EQ(layout.outcomes.back().dims[0].names,
            (std::vector<std::string>{"die face: die 1", "die face: die 2", "die face: die 3",
                                      "die 1 event"}));
  const archive::Motion motion = reader->play(bytes);
  EXPECT_EQ(motion.ends, archive::PlaysOut::yes);
  EXPECT_FALSE(motion.segments.empty());
  // Die 1 has an event, and die 3 starts late, so no two dice are interchangeable.
  for (std::uint32_t die = 0; die < 3; ++die)
    EXPECT_EQ(reader->scene().features[die].twin_of, die);
  EXPECT_EQ(reader->scene().parts.front().shape, scene::Shape::die);
  const auto likeness = reader->likeness(bytes);
  EXPECT_EQ(reader->likeness_distance(likeness, likeness), 0);
}

}  // namespace
}  // namespace sleight::worlds::user_scene
