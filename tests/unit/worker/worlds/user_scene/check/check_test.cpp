// The check of a scene: overlaps against the simulator's verdict and known depths, known runs, and
// the facts in the report.
#include "worker/worlds/user_scene/check/check.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/random/stream.h"
#include "worker/physics/shape/shapes.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::worlds::user_scene {
namespace {

BodyDescription body(const char* name, const ShapeSizes& sizes, const Vec3& place_m) {
  return {.name = name, .sizes = sizes, .place = {.position_m = place_m}};
}
BodyDescription fixed(const char* name, const ShapeSizes& sizes, const Vec3& place_m) {
  return {.name = name, .sizes = sizes, .is_static = true, .place = {.position_m = place_m}};
}
const ShapeSizes k_ball{.kind = ShapeKind::sphere, .radius_m = 0.01};
const ShapeSizes k_plane{.kind = ShapeKind::plane};
ShapeSizes box(const Vec3& size_m) {
  return {.kind = ShapeKind::box, .size_m = size_m};
}

/// A closed mesh. If an odd number of sizes is negative, the mesh is inside out.
ShapeSizes tetrahedron(const Vec3& size_m) {
  return {.kind = ShapeKind::mesh,
          .points_m = {{0, 0, 0}, {size_m.x(), 0, 0}, {0, size_m.y(), 0}, {0, 0, size_m.z()}},
          .triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
}

/// An open sheet: a square floor of side 2 r at z = 0, and four walls that lean outwards.
ShapeSizes cup(double r) {
  ShapeSizes mesh{.kind = ShapeKind::mesh, .triangles = {{0, 1, 2}, {0, 2, 3}}};
  for (const auto& [s, z] : {std::pair(r, 0.0), std::pair(2 * r, 2 * r)})
    mesh.points_m.insert(mesh.points_m.end(), {{-s, -s, z}, {s, -s, z}, {s, s, z}, {-s, s, z}});
  for (std::uint32_t i = 0, k = 1; i < 4; ++i, k = (i + 1) % 4)
    mesh.triangles.insert(mesh.triangles.end(), {{i, 4 + i, 4 + k}, {i, 4 + k, k}});
  return mesh;
}

SceneDescription scene_of(const std::vector<BodyDescription>& bodies) {
  return {.materials = {{.name = "oak"}},
          .pairs = {},
          .groups = {"all", "ghosts"},
          .no_contact = {{{0, 1}}},
          .bodies = bodies};
}
std::vector<Overlap> overlaps(const std::vector<BodyDescription>& bodies) {
  return overlaps_of(build(scene_of(bodies)).value());
}

/// The centre of mass is between the bars.
const std::vector<PartDescription> k_two_bars{
    {.sizes = box({0.3, 0.05, 0.05})},
    {.sizes = box({0.3, 0.05, 0.05}), .pose = {.position_m = {0, 0, 0.2}}}};

Vec3 vector_between(random::Stream& stream, double low, double high) {
  const auto draw = [&] { return low + (high - low) * stream.uniform(); };
  return Vec3{draw(), draw(), draw()};
}

/// A body of any shape. A static one may also be a plane or a mesh.
BodyDescription random_body(random::Stream& stream, bool is_static) {
  const auto kind = static_cast<std::uint8_t>((is_static ? 14 : 9) * stream.uniform());
  const Vec3 size_m = vector_between(stream, 0.05, 0.3);
  BodyDescription one{
      .name = std::to_string(stream.bits()),
      .sizes = box(size_m),
      .is_static = is_static,
      .place = {.position_m = vector_between(stream, -0.4, 0.4),
                .orientation = math::quaternion_of_rotation_vector(vector_between(stream, -2, 2))}};
  one.group = stream.uniform() < 0.1 ? 1 : 0;
  one.sizes.kind = ShapeKind{kind};
  one.sizes.radius_m = 0.3 * size_m.x();
  one.sizes.length_m = 0.7 * size_m.x() + size_m.y();
  one.sizes.edge_m = 0.004;
  for (int i = 0; i < 10; ++i)
    one.sizes.points_m.push_back(vector_between(stream, -0.15, 0.15));
  if (one.sizes.kind == ShapeKind::compound) one.parts = k_two_bars;
  if (kind == 9) one.place.position_m -= math::rotated(one.place.orientation, Vec3(0, 0, 0.5));
  if (kind == 10 || kind == 11) one.sizes = tetrahedron((kind == 10 ? 4 : 15) * size_m);
  if (kind >= 12) one.sizes = cup(size_m.x());
  return one;
}

// The simulator refuses a scene for an overlap if and only if overlaps_of() finds one.
TEST(Overlaps, AgreeWithTheSimulator) {
  std::uint64_t refused = 0;
  constexpr std::uint64_t k_scenes = 400;
  for (std::uint64_t number = 0; number < k_scenes; ++number) {
    random::Stream stream({.seed = 7, .purpose = random::Purpose::scene}, number);
    std::vector<BodyDescription> bodies;
    for (int i = 0; i < 5; ++i) {
      bodies.push_back(random_body(stream, i > 2));
      bodies.back().start_s = i <= 2 && number % 3 == 0 ? 0.5 : 0;
    }
    const BuiltScene built = build(scene_of(bodies)).value();
    auto simulation = physics::Simulation::start(built.scene, {});
    std::optional<physics::SceneError> error;
    if (!simulation) error = simulation.error();
    if (simulation)
      error = std::move(simulation).value().run_until(built.scene.bodies[0].start_tick);
    EXPECT_TRUE(!error || error->kind == physics::SceneError::Kind::overlap) << error->message;
    EXPECT_EQ(overlaps_of(built).empty(), !error) << "scene " << number;
    refused += error ? 1 : 0;
  }
  EXPECT_TRUE(refused > k_scenes / 5 && refused < k_scenes * 4 / 5) << refused;
}

// Pairs of simple shapes whose depth is known.
TEST(Overlaps, HaveKnownDepths) {
  const BodyDescription ball = body("ball", k_ball, Vec3::Zero());
  const BodyDescription cube = body("cube", box({0.02, 0.02, 0.02}), Vec3::Zero());
  const auto depth_mm = [](const BodyDescription& a, const BodyDescription& b) {
    const std::vector<Overlap> found = overlaps({a, b});
    return found.size() == 1 && !found[0].inside ? 1e3 * found[0].depth_m : -1;
  };
  EXPECT_NEAR(depth_mm(ball, body("b", k_ball, {0.015, 0, 0})), 5, 1e-9);
  EXPECT_NEAR(depth_mm(ball, body("b", k_ball, Vec3::Zero())), 20, 1e-9);
  EXPECT_EQ(depth_mm(ball, body("b", k_ball, {0.02 + 5e-8, 0, 0})), 0);
  EXPECT_EQ(depth_mm(ball, body("b", k_ball, {0.0201, 0, 0})), -1);
  EXPECT_NEAR(depth_mm(ball, fixed("b", k_plane, {0, 0, -0.008})), 2, 1e-9);
  EXPECT_NEAR(depth_mm(ball, fixed("b", cup(0.05), {0, 0, -0.008})), 2, 1e-9);
  EXPECT_NEAR(depth_mm(cube, body("b", box({0.04, 0.04, 0.04}), {0.001, 0, 0.027})), 3, 1e-9);
  // Much deeper than the cylinder's rounded edges.
  const ShapeSizes cylinder{
      .kind = ShapeKind::cylinder, .radius_m = 0.02, .length_m = 0.04, .edge_m = 1e-4};
  EXPECT_NEAR(depth_mm(cube, fixed("b", cylinder, {0, 0, 0.026})), 4, 0.01);
  BodyDescription later = body("b", k_ball, {0.015, 0, 0});
  later.start_s = 1;
  EXPECT_EQ(depth_mm(ball, later), -1);
  BodyDescription at_rest = cube;
  at_rest.rests = true;
  EXPECT_EQ(depth_mm(at_rest, fixed("b", k_plane, {0, 0, -0.01 + 5e-7})), -1);
  EXPECT_NEAR(depth_mm(at_rest, fixed("b", k_plane, {0, 0, -0.01 + 2e-6})), 2e-3, 1e-9);
}

// Bodies that touch nothing of a solid's surface.
TEST(Overlaps, FindBodiesInsideMeshes) {
  const BodyDescription small = body("small", k_ball, {0.1, 0.1, 0.1});
  const auto found = overlaps({small, fixed("block", tetrahedron({1, 1, 1}), Vec3::Zero())});
  EXPECT_TRUE(found.size() == 1 && found[0].inside);
  // The simulator looks for a solid only at the centre of mass.
  BodyDescription bars = body("bars", {.kind = ShapeKind::compound}, Vec3::Zero());
  bars.parts = k_two_bars;
  EXPECT_EQ(overlaps({bars, fixed("pole", box({0.02, 1, 0.02}), {0, 0, 0.1})}).size(), 1U);
  EXPECT_TRUE(overlaps({small, fixed("cavity", tetrahedron({-1, 1, 1}), {0.4, 0, 0})}).empty());
}

// A pin's origin is its foot, not its centre of mass.
TEST(NominalRun, GivesPlacesInTheUsersFrame) {
  SceneDescription scene =
      scene_of({body("pin", {.kind = ShapeKind::pin}, {0.1, 0.2, 0}),
                body("ball", k_ball, {5, 0, 0.5}), fixed("floor", k_plane, Vec3::Zero())});
  scene.bodies[0].rests = true;
  const NominalRun run = nominal_run(scene, build(scene).value());
  EXPECT_TRUE(run.bodies[0].end == BodyEnd::rests && run.bodies[0].rests_since_s == 0);
  EXPECT_NEAR(math::norm(run.bodies[0].place.position_m - Vec3(0.1, 0.2, 0)), 0, 1e-9);
  EXPECT_EQ(run.bodies[1].end, BodyEnd::rests);
  EXPECT_EQ(nominal_run(scene, build(scene).value(), 5).end, RunEnd::work_limit);
  // Without slow contacts, the ball bounces ever lower, until the simulator fails.
  scene.bodies.erase(scene.bodies.begin());
  scene.separation_speed_mps = scene.rest_speed_mps = scene.rest_time_s = 0;
  const NominalRun failed = nominal_run(scene, build(scene).value());
  EXPECT_TRUE(failed.end == RunEnd::error && failed.error);
  EXPECT_NEAR(failed.bodies[0].place.position_m.z(), 0.01, 1e-3);
}

void expect_parts(const std::string& text, const std::vector<std::string>& parts) {
  for (const std::string& part : parts)
    EXPECT_NE(text.find(part), std::string::npos) << part << " in\n" << text;
}

// One ball falls into a cup, another beside it. Free fall gives the time of the first hit.
TEST(Report, TellsWhatHappensInADrop) {
  SceneDescription scene =
      scene_of({body("ball", k_ball, {0.01, 0.005, 0.21}), body("lost", k_ball, {0.5, 0, 0.1}),
                fixed("cup", cup(0.05), Vec3::Zero())});
  scene.bodies[0].mass_kg = 0.0125;
  const BuiltScene built = build(scene).value();
  const SceneReport report = check(scene, built);
  const NominalRun& run = report.run.value();
  EXPECT_TRUE(run.end == RunEnd::all_ended && run.end_s < 5);
  EXPECT_TRUE(run.bodies.at(0).end == BodyEnd::rests && run.bodies.at(1).end == BodyEnd::left);
  EXPECT_NEAR(run.bodies[0].place.position_m.z(), 0.01, 1e-5);
  ASSERT_TRUE(run.hits.size() == 1 && run.hits[0].a == 0 && run.hits[0].b == 2);
  EXPECT_EQ(run.hits[0].count, run.bodies[0].hits);
  EXPECT_NEAR(run.hits[0].first_s, std::sqrt(2 * 0.2 / 9.81), 1e-6);
  EXPECT_EQ(report.warnings.size(), 1U);
  // Mass, moments, boundary edges, first hit, height at the end.
  expect_parts(report_text(report), {"'lost' falls", "ball", "cup", "oak", "12.5", "500 500 500",
                                     "open", "4", "left", "rests", "0.202", " 10.00"});
}

// Each fault of a scene has a warning with the names of its objects.
TEST(Report, WarnsOfWhatIsWrong) {
  SceneDescription scene =
      scene_of({body("heavy", k_ball, {0, 0, 0.2}), body("light", k_ball, {0, 0, 0.219}),
                fixed("rock", tetrahedron({-0.1, 0.1, 0.1}), {5, 0, 0})});
  const BuiltScene built = build(scene).value();
  const SceneReport report = check(scene, built);
  EXPECT_NEAR(report.meshes.at(0).volume_m3, -1e-3 / 6, 1e-12);
  EXPECT_FALSE(report.run);
  expect_parts(report_text(report), {"'rock' is inside out", "'heavy' overlaps 'light' by 1 mm",
                                     "'heavy' is inside 'rock'", "'light' is inside 'rock'"});
  scene.bodies.pop_back();
  scene.bodies[0].mass_kg = 2;
  scene.bodies[1].mass_kg = 1e-4;
  scene.bodies[1].place.position_m.z() = 0.221;
  scene.bodies[1].velocity_mps.z() = -1;
  const BuiltScene meeting = build(scene).value();
  expect_parts(report_text(check(scene, meeting)), {"'heavy' and 'light' meet", "2e+04"});
}

// Draws from the prior tell how often bodies overlap or still move, and what no draw comes near.
TEST(PriorDraws, TellWhatUsuallyHappens) {
  Parameters parameters{
      .scene = scene_of({body("ball", k_ball, {0, 0, 0.02}), fixed("floor", k_plane, {0, 0, 0})}),
      .built = {},
      .uncertain = {{.name = "height", .targets = {0}, .sd = {0, 0, 0}, .within = {0, 0, 0.015}}},
      .constraints = {{.name = "far",
                       .asks = Asks::place,
                       .bodies = {0},
                       .region = {.low_m = {1, 0, 0.01}, .high_m = {1, 0, 0.01}},
                       .sigma = 0.1}}};
  parameters.scene.materials[0].law.restitution = 0.999;
  parameters.scene.end_s = 0.5;
  parameters.built = std::make_shared<const BuiltScene>(build(parameters.scene).value());
  const UserScene world(parameters);
  const PriorDraws draws = prior_draws(world, 600, [](std::uint64_t) { return true; });
  ASSERT_EQ(draws.count, 600U);
  // The ball touches the floor below 10 mm: a sixth of 5 to 35 mm. 5 standard errors are 46.
  EXPECT_NEAR(static_cast<double>(draws.overlap), 100, 46);
  EXPECT_EQ(draws.not_settled, 600 - draws.overlap);
  EXPECT_EQ(draws.met + draws.failed, 0U);
  EXPECT_NEAR(draws.values[2][0], 5, 0.3);
  EXPECT_NEAR(draws.values[2][2], 35, 0.3);
  EXPECT_NEAR(draws.least_distances[0], 1, 0.03);
  SceneReport report = check(parameters.scene, *parameters.built);
  add_draws(world, draws, report);
  expect_parts(report_text(report),
               {"of 600 prior draws, bodies overlap", "of 600 prior draws, a body still moves",
                "None of 600 prior draws comes near constraint 'far': the least distance is",
                "Prior draws: 600", "height z"});
}

}  // namespace
}  // namespace sleight::worlds::user_scene
