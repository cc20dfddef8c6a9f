// Goal: a scene is read as written, and each mistake gets one error with its place. Method: read
// small scenes. Compare what was read with the text, read the normalised text again, and compare
// the errors of bad scenes with the expected ones.
#include <gtest/gtest.h>

#include "tests/unit/worker/worlds/user_scene/read_scene.h"

namespace sleight::worlds::user_scene {
namespace {

constexpr std::string_view k_every_shape = R"(
gravity_mps2 = [0, 0, -1.62]
[[world.material]]
name = "glass"
density_kgpm3 = 2500
restitution = 0.7
[[world.material]]
name = "felt"
friction = 0.9
[[world.contact]]
materials = ["glass", "felt"]
restitution = 0.1
[[world.body]]
name = "floor"
shape = "plane"
material = "felt"
friction_patch = [{x_mm = [0, 100], y_mm = [0, 50], friction = 0.04}]
[[world.body]]
name = "marble"
radius_mm = 8
at_mm = [0, 0, 400]
velocity_mps = [0.1, 0, 0]
group = "marbles"
[[world.body]]
name = "box"
shape = "box"
size_mm = [10, 20, 30]
turn_deg = [0, 0, 90]
grid = {count = [2, 1, 2], step_mm = [50, 0, 60]}
at_mm = [200, 0, 100]
[[world.body]]
name = "capsule"
shape = "capsule"
radius_mm = 5
length_mm = 30
row = {count = 3, step_mm = [0, 40, 0]}
at_mm = [400, 0, 100]
[[world.body]]
name = "cylinder"
shape = "cylinder"
radius_mm = 5
length_mm = 30
ring = {count = 4, radius_mm = 500}
[[world.body]]
name = "cone"
shape = "cone"
radius_mm = 20
length_mm = 30
edge_mm = 1
static = true
[[world.body]]
name = "soap"
shape = "rounded_box"
size_mm = [60, 40, 20]
edge_mm = 8
mass_kg = 0.1
at_mm = [600, 0, 100]
[[world.body]]
name = "pin"
shape = "pin"
mass_kg = 1.5
rests = true
[[world.body]]
name = "wedge"
shape = "hull"
points_mm = [[0, 0, 0], [30, 0, 0], [0, 30, 0], [0, 0, 30]]
static = true
[[world.body]]
name = "hammer"
shape = "compound"
at_mm = [800, 0, 100]
[[world.body.part]]
shape = "cylinder"
radius_mm = 5
length_mm = 100
[[world.body.part]]
shape = "box"
size_mm = [20, 20, 60]
at_mm = [0, 0, 60]
turn_deg = [0, 90, 0]
density_kgpm3 = 7800
[[world.body]]
name = "tent"
shape = "mesh"
points_mm = [[0, 0, 0], [30, 0, 0], [0, 30, 0], [0, 0, 30]]
triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
closed = true
[[world.body]]
name = "helix"
shape = "helix"
radius_mm = 14
path_radius_mm = 60
drop_mm = 150
turns = 3
[[world.body]]
name = "ramp"
shape = "ramp"
radius_mm = 14
length_mm = 300
drop_mm = 20
[[world.no_contact]]
groups = ["marbles", "default"]
)";

TEST(SceneRequest, EveryShapeIsReadAndBuilt) {
  const SceneDescription scene = scene_of(std::string(k_every_shape));
  EXPECT_EQ(scene.gravity_mps2.z(), -1.62);
  ASSERT_EQ(scene.bodies.size(), 13U);
  EXPECT_EQ(scene.bodies[1].place.position_m, Vec3(0, 0, 0.4));
  EXPECT_EQ(scene.no_contact.front(), (std::array<std::uint32_t, 2>{1, 0}));

  const BuiltScene built = built_scene(scene);
  // One marble, four boxes, three capsules, four cylinders, the soap, the pin and the hammer move.
  EXPECT_EQ(built.moving, 15U);
  EXPECT_EQ(built.bodies, 16U) << "the cone is a fixed body";
  EXPECT_EQ(built.objects[4].name, "box 4");
  EXPECT_TRUE(built.objects[4].place.position_m.isApprox(Vec3(0.25, 0, 0.16)));
  EXPECT_EQ(built.scene.planes.size(), 1U);
  EXPECT_EQ(built.scene.convexes.size(), 1U);
  ASSERT_EQ(built.scene.meshes.size(), 3U);
  EXPECT_EQ(built.scene.meshes[1].mesh->triangles().size(), 2U * 288 * 8);
  // The third of four cylinders is opposite the first.
  EXPECT_TRUE(built.objects[10].place.position_m.isApprox(Vec3(-0.5, 0, 0)));

  const physics::SurfaceLaw law = built.scene.contacts.between({1}, {0});
  EXPECT_EQ(law.restitution, 0.1);
  EXPECT_DOUBLE_EQ(law.friction, 0.6) << "the mean of 0.3 and 0.9";
  EXPECT_EQ(built.scene.contacts.between({0}, {0}).restitution, 0.7);
  EXPECT_EQ(built.scene.planes[0].friction_map->friction_at({0.05, 0.02, 0}), 0.04);
}

TEST(SceneRequest, TheNormalisedTextIsReadAsTheSameRequest) {
  const auto request = read_scene("[world]\nname = \"scene\"\n" + std::string(k_every_shape));
  ASSERT_TRUE(request.ok());
  const std::string text = request::normalised_text(request.value());
  const auto again = read_scene(text);
  ASSERT_TRUE(again.ok()) << to_string(again.error().front()) << '\n' << text;
  EXPECT_EQ(request::normalised_text(again.value()), text);
}

struct Mistake {
  std::string text;   ///< behind `[world]` and the name; its first line is line 3
  std::string error;  ///< behind the file's name
};

class SceneMistake : public testing::TestWithParam<Mistake> {};

TEST_P(SceneMistake, HasOneErrorWithItsPlace) {
  const auto request = read_scene("[world]\nname = \"scene\"\n" + GetParam().text);
  ASSERT_FALSE(request.ok());
  std::string errors;
  for (const request::Diagnostic& diagnostic : request.error())
    errors += to_string(diagnostic) + "\n";
  EXPECT_EQ(errors, "s.toml:" + GetParam().error + "\n");
}

std::string body(const std::string& keys) {
  return "[[world.body]]\nname = \"a\"\n" + keys;
}

const std::vector<Mistake> k_mistakes{
    {"", "1:2: 'body' in [world]: missing; a scene needs at least one [[world.body]]"},
    {"[[world.body]]\nradius_mm = 5\n",
     "3:1: 'name' in [[world.body]]: missing; expected a string of at most 64 characters"},
    {"[[world.body]]\nname = \"\"\nradius_mm = 5\n",
     "4:1: 'name' in [[world.body]]: expected the body's name, found an empty string"},
    {body("radius_mm = 5\n") + body("radius_mm = 6\nat_mm = [50, 0, 0]\n"),
     "7:1: 'name' in [[world.body]]: another body is already named \"a\""},
    {body("shape = \"ball\"\nradius_mm = 5\n"),
     "5:9: 'shape' in [[world.body]]: expected one of \"sphere\", \"box\", \"capsule\", "
     "\"cylinder\", \"cone\", \"rounded_box\", \"pin\", \"hull\", \"compound\", \"plane\", "
     "\"mesh\", \"helix\", \"ramp\", found the string \"ball\"; did you mean \"hull\"?"},
    {body("shape = \"box\"\nradius_mm = 5\nsize_mm = [1, 2, 3]\n"),
     "6:1: 'radius_mm' in [[world.body]]: a box doesn't use this key; its keys are size_mm"},
    {body("shape = \"box\"\n"), "3:1: 'size_mm' in [[world.body]]: missing; a box needs it"},
    {body("shape = \"box\"\nsize_mm = [1, 2]\n"),
     "6:11: 'size_mm' in [[world.body]]: expected 3 numbers, each a number from 0.01 to 1000000 "
     "mm, found an array of 2"},
    {body("shape = \"box\"\nsize_mm = [1, 2, nan]\n"),
     "6:18: 'size_mm' in [[world.body]]: element 3: expected a number from 0.01 to 1000000 mm, "
     "found nan"},
    {body("shape = \"box\"\nsize_mm = [1, 2, -3]\n"),
     "6:18: 'size_mm' in [[world.body]]: element 3: expected a number from 0.01 to 1000000 mm, "
     "found -3"},
    {body("radius_mm = 0\n"),
     "5:13: 'radius_mm' in [[world.body]]: expected a number from 0.01 to 1000000 mm, found 0"},
    {body("radius_mm = 5\nradus_mm = 5\n"),
     "6:1: unknown key 'radus_mm' in [[world.body]]; did you mean 'radius_mm'?"},
    {body("radius_mm = 5\nmaterial = \"gold\"\n"),
     "6:1: 'material' in [[world.body]]: no material is named \"gold\"; the names are \"default\""},
    {"[[world.material]]\nname = \"glass\"\n" + body("radius_mm = 5\nmaterial = \"glas\"\n"),
     "8:1: 'material' in [[world.body]]: no material is named \"glas\"; did you mean \"glass\"?"},
    {"[[world.material]]\nname = \"glass\"\n[[world.material]]\nname = \"glass\"\n" +
         body("radius_mm = 5\n"),
     "6:1: 'name' in [[world.material]]: another material is already named \"glass\""},
    {"[[world.material]]\nname = \"glass\"\n[[world.contact]]\nmaterials = [\"glass\"]\n" +
         body("radius_mm = 5\n"),
     "6:13: 'materials' in [[world.contact]]: expected 2 strings, each a string of at most 64 "
     "characters, found an array of 1"},
    {"[[world.material]]\nname = \"g\"\n[[world.contact]]\nmaterials = [\"g\", \"g\"]\n"
     "[[world.contact]]\nmaterials = [\"g\", \"g\"]\n" +
         body("radius_mm = 5\n"),
     "8:1: 'materials' in [[world.contact]]: another [[world.contact]] already has this pair"},
    {body("radius_mm = 5\n") + "[[world.no_contact]]\ngroups = [\"default\", \"ghost\"]\n",
     "7:1: 'groups' in [[world.no_contact]]: no group is named \"ghost\"; the names are "
     "\"default\""},
    {body("shape = \"plane\"\nstatic = false\n"),
     "6:1: 'static' in [[world.body]]: a plane can't move; remove the key"},
    {body("shape = \"plane\"\nvelocity_mps = [1, 0, 0]\n"),
     "6:1: 'velocity_mps' in [[world.body]]: a static body has no such key; remove it"},
    {body("radius_mm = 5\nstatic = true\nmass_kg = 1\n"),
     "7:1: 'mass_kg' in [[world.body]]: a static body has no such key; remove it"},
    {body("radius_mm = 5\nrests = true\nstart_s = 1\n"),
     "6:1: 'rests' in [[world.body]]: a body at rest is there from the start; remove start_s"},
    {body("radius_mm = 5\nturn_deg = [0, 0, 9]\nquaternion = [1, 0, 0, 0]\n"),
     "7:1: 'quaternion' in [[world.body]]: set either turn_deg or quaternion, not both"},
    {body("radius_mm = 5\nquaternion = [0, 0, 0, 0]\n"),
     "6:1: 'quaternion' in [[world.body]]: the numbers are too small to be a rotation"},
    {body("radius_mm = 5\nrow = {count = 2, step_mm = [9, 0, 0]}\nring = {count = 2}\n"),
     "7:1: 'ring' in [[world.body]]: set only one of row, grid and ring"},
    {body("radius_mm = 5\nrow = {count = 0}\n"),
     "6:16: 'count' in [world.body.row]: expected an integer from 1 to 1000, found 0"},
    {body("radius_mm = 5\ngrid = {count = [100, 100, 1]}\n"),
     "6:1: 'grid' in [[world.body]]: the scene has more than 1000 bodies and static things"},
    {body("shape = \"cylinder\"\nradius_mm = 5\nlength_mm = 4\nedge_mm = 3\n"),
     "8:1: 'edge_mm' in [[world.body]]: expected at most the radius and half of the length, 2 mm, "
     "found 3"},
    {body("shape = \"capsule\"\nradius_mm = 5\nlength_mm = 9\n"),
     "7:1: 'length_mm' in [[world.body]]: expected more than the diameter, 10 mm, found 9"},
    {body("shape = \"hull\"\npoints_mm = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\n"),
     "6:1: 'points_mm' in [[world.body]]: a solid needs at least 4 points, found 3"},
    {body("shape = \"hull\"\npoints_mm = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]\n"),
     "6:1: 'points_mm' in [[world.body]]: the points are nearly coplanar: their thickness is 0 "
     "times their extent, expected at least 1e-06 times"},
    {body("shape = \"hull\"\npoints_mm = [[0, 0, 0], [1, 0], [0, 1, 0], [1, 1, 0]]\n"),
     "6:25: 'points_mm' in [[world.body]]: row 2: expected 3 numbers, each a number from -1000000 "
     "to 1000000 mm, found an array of 2"},
    {body("shape = \"mesh\"\npoints_mm = [[0, 0, 0], [1, 0, 0], [2, 0, 0]]\n"
          "triangles = [[0, 1, 2]]\n"),
     "7:1: 'triangles' in [[world.body]]: triangle 0 has no area: its height is below 1e-06 times "
     "its longest side"},
    {body("shape = \"mesh\"\npoints_mm = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\n"
          "triangles = [[0, 1, 3]]\n"),
     "7:1: 'triangles' in [[world.body]]: triangle 0: vertex 3 does not exist"},
    {body("shape = \"mesh\"\npoints_mm = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\n"
          "triangles = [[0, 1, 2]]\nclosed = true\n"),
     "7:1: 'triangles' in [[world.body]]: the mesh is not closed: an edge of triangle 0 (at vertex "
     "0) has no second triangle"},
    {body("shape = \"mesh\"\npoints_mm = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]\n"
          "triangles = [[0, 1, 2], [1, 2, 3]]\n"),
     "7:1: 'triangles' in [[world.body]]: triangles 0 and 1 traverse their common edge (at vertex "
     "1) in the same direction, so one triangle is inside out"},
    {body("shape = \"helix\"\nradius_mm = 9\npath_radius_mm = 50\ndrop_mm = 50\nturns = 500\n"
          "steps = 50000\nstrips = 64\n"),
     "10:1: 'steps' in [[world.body]]: with this body, the scene has 6400000 triangles; the limit "
     "is 200000"},
    {body("shape = \"helix\"\nradius_mm = 9\npath_radius_mm = 9\ndrop_mm = 50\nturns = 5\n"),
     "6:1: 'radius_mm' in [[world.body]]: expected less than path_radius_mm, 9 mm, found 9"},
    {body("shape = \"helix\"\nradius_mm = 9\npath_radius_mm = 50\ndrop_mm = 50\nturns = 0\n"),
     "9:1: 'turns' in [[world.body]]: must not be 0; a straight channel is a ramp"},
    {"[[world.body]]\nname = \"a\\u001b\"\nradius_mm = 5\n",
     "4:1: 'name' in [[world.body]]: expected a name without control characters"},
    {body("shape = \"compound\"\n"), "3:1: 'part' in [[world.body]]: missing; a compound needs it"},
    {body("shape = \"compound\"\n[[world.body.part]]\nshape = \"plane\"\n"),
     "7:9: 'shape' in [[world.body.part]]: expected one of \"sphere\", \"box\", \"capsule\", "
     "\"cylinder\", \"cone\", \"rounded_box\", \"pin\", \"hull\", found the string \"plane\""},
    {body("shape = \"compound\"\n[[world.body.part]]\nshape = \"box\"\nsize_mm = [1, 1]\n"),
     "8:11: 'size_mm' in [[world.body.part]]: expected 3 numbers, each a number from 0.01 to "
     "1000000 mm, found an array of 2"},
    {body("shape = \"compound\"\n[[world.body.part]]\nradius_mm = 4\nmass_kg = 2\n"),
     "8:1: unknown key 'mass_kg' in [[world.body.part]]; known keys: 'shape', 'radius_mm', "
     "'length_mm', 'size_mm', 'edge_mm', 'points_mm', 'at_mm', 'turn_deg', 'quaternion', "
     "'density_kgpm3'"},
    {body("shape = \"plane\"\nfriction_patch = [{x_mm = [5, 5], y_mm = [0, 1]}]\n"),
     "6:20: 'x_mm' in [[world.body.friction_patch]]: the first number must be less than the "
     "second"},
};

INSTANTIATE_TEST_SUITE_P(All, SceneMistake, testing::ValuesIn(k_mistakes));

}  // namespace
}  // namespace sleight::worlds::user_scene
