// Goal: a sphere meets static geometry exactly where it touches the surface. Method: for a mesh or
// polyhedron, compare the distance to the closest feature with the distance to the closest
// triangle. Use random centres, and centres above corners, edges and diagonals. features_near()
// must also find the closest feature. (penetration_test.cpp tests whole simulations, in which
// nothing may fall through.)
#include "worker/physics/scene/static_geometry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/random/stream.h"
#include "tests/scenes/shared/scenes.h"
#include "tests/support/property.h"
#include "tests/unit/worker/physics/scene/random_meshes.h"
#include "worker/physics/shape/convex_polyhedron.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::physics {
namespace {

using testing::mesh_of;
using testing::open_mesh;
using testing::Raw;
using testing::sheet;
using testing::star;
using testing::vector_between;

random::Stream stream_of(std::uint64_t part) {
  return random::Stream({.seed = 12, .purpose = random::Purpose::scene}, part);
}

// ---- the slow reference -------------------------------------------------------------------------

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double part = std::clamp(math::dot(p - a, along) / math::dot(along, along), 0.0, 1.0);
  return math::norm(p - (a + part * along));
}

/// Distance by definition. If the foot is inside the triangle, the distance is to the plane, else
/// to the closest side.
double distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = math::cross(b - a, c - a);
  const auto left = [&](const Vec3& from, const Vec3& to) {
    return math::dot(math::cross(to - from, p - from), normal) >= 0;
  };
  if (left(a, b) && left(b, c) && left(c, a))
    return std::fabs(math::dot(p - a, normal)) / math::norm(normal);
  return std::min(
      {distance_to_segment(p, a, b), distance_to_segment(p, b, c), distance_to_segment(p, c, a)});
}

double distance_to_mesh(const TriangleMesh& mesh, const Vec3& p) {
  double least_m = 1e300;
  for (const TriangleCorners& t : mesh.triangles()) {
    const auto corner = [&](std::size_t k) { return mesh.vertices_m()[t[k]]; };
    least_m = std::min(least_m, distance_to_triangle(p, corner(0), corner(1), corner(2)));
  }
  return least_m;
}

// ---- scenes -------------------------------------------------------------------------------------

/// A scene with a body of each kind, so that features and pieces exist.
Scene scene_of(std::shared_ptr<const TriangleMesh> mesh) {
  Scene scene = scenes::bumpy_floor(2, 1).scene;
  scene.planes.clear();
  scene.meshes = {{.name = "it", .mesh = std::move(mesh)}};
  return scene;
}

// ---- regions ------------------------------------------------------------------------------------

constexpr FeatureId k_none{UINT32_MAX};

struct Closest {
  FeatureId feature = k_none;
  double distance_m = 1e300;
};

Closest closest_feature(const StaticGeometry& geometry, const Vec3& p) {
  const MovingPoint still{
      .position_m = p, .velocity_mps = Vec3::Zero(), .acceleration_mps2 = Vec3::Zero()};
  Closest closest;
  for (FeatureId i{}; i < geometry.feature_count(); ++i) {
    const SphereFeature& feature = geometry.feature(i);
    if (outside_for_s(geometry.sides(feature), still) > 0) continue;
    const double distance_m = gap_between(feature, still, 0).gap_m;
    if (distance_m < closest.distance_m) closest = {i, distance_m};
  }
  return closest;
}

/// Expects that the closest feature is right. If a sphere touches this feature, features_near()
/// must find it from the sphere's box.
void expect_closest(const StaticGeometry& geometry, const TriangleMesh& mesh, const Vec3& p) {
  const double expected_m = distance_to_mesh(mesh, p);
  const Closest closest = closest_feature(geometry, p);
  ASSERT_NE(closest.feature, k_none) << "no feature at " << p.transpose();
  ASSERT_NEAR(closest.distance_m, expected_m, 1e-13) << "at " << p.transpose();
  Box box;
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    // The box is rounded outwards, so that it contains the sphere.
    constexpr float k_far = std::numeric_limits<float>::infinity();
    box.low_m[axis] = std::nextafter(static_cast<float>(p[i] - expected_m), -k_far);
    box.high_m[axis] = std::nextafter(static_cast<float>(p[i] + expected_m), k_far);
  }
  std::vector<StaticId> near;
  geometry.features_near(box, expected_m, near);
  EXPECT_TRUE(std::ranges::is_sorted(near, std::less_equal<>{}) || near.size() < 2);
  EXPECT_TRUE(std::ranges::binary_search(near, StaticId{closest.feature}));
}

TEST(StaticGeometry, AnOpenMeshIsMetWhereItIsClosestFromBothSides) {
  int below = 0;
  for (const std::uint64_t part : property::cases(20)) {
    random::Stream stream = stream_of(part);
    const auto mesh = open_mesh(sheet(4, 0.1, 0.1, stream));
    const StaticGeometry geometry(scene_of(mesh));
    for (int i = 0; i < 300; ++i) {
      Vec3 p = vector_between(stream, -0.1, 0.5);
      p.z() = 0.4 * stream.uniform() - 0.15;
      below += p.z() < 0;
      ASSERT_NO_FATAL_FAILURE(expect_closest(geometry, *mesh, p));
    }
  }
  if (!property::all_cases()) return;
  EXPECT_GT(below, 1000);
}

TEST(StaticGeometry, AClosedMeshIsMetWhereItIsClosestFromOutside) {
  int outside = 0;
  int hollow = 0;
  for (std::uint64_t part = 100; part < 110; ++part) {
    random::Stream stream = stream_of(part);
    const auto mesh = mesh_of(star(stream, part % 2 == 0 ? 0.4 : 0), MeshClosure::closed);
    const StaticGeometry geometry(scene_of(mesh));
    hollow +=
        static_cast<int>(std::ranges::count(mesh->edges(), EdgeKind::concave, &MeshEdge::kind));
    for (int i = 0; i < 400; ++i) {
      const Vec3 p = vector_between(stream, -1.3, 1.3);
      if (geometry.solid_at(p) != nullptr) {
        // Radii are at least 0.6, so the mesh is a star and its solid part is within 1.
        EXPECT_LT(math::norm(p), 1);
        continue;
      }
      EXPECT_GT(math::norm(p), 0.5);
      ++outside;
      ASSERT_NO_FATAL_FAILURE(expect_closest(geometry, *mesh, p));
    }
  }
  EXPECT_GT(outside, 1500);
  EXPECT_GT(hollow, 50);
}

TEST(StaticGeometry, NoCracksAboveCornersEdgesAndDiagonals) {
  // With heights of 0, all inner edges are flat and inner corners have no features. A tilt adds
  // rounding errors.
  for (std::uint64_t part = 200; part < 240; ++part) {
    random::Stream stream = stream_of(part);
    Raw raw = sheet(4, 0.1, part % 2 == 0 ? 0 : 0.05, stream);
    const Vec3 tilt = part % 4 < 2 ? Vec3(0, 0, 1) : vector_between(stream, -0.3, 0.3);
    for (Vec3& v : raw.vertices_m)
      v.z() += tilt.x() * v.x() + tilt.y() * v.y();
    const auto mesh = open_mesh(raw);
    const StaticGeometry geometry(scene_of(mesh));
    for (const MeshEdge& edge : mesh->edges()) {
      const Vec3 start_m = edge.start_m;
      const Vec3 end_m = mesh->vertices_m()[edge.vertex[1]];
      for (const double at : {0.0, 0.5, stream.uniform(), 1.0}) {
        const Vec3 on_m = start_m + at * (end_m - start_m);
        for (const double height_m : {-0.3, -0.01, 0.01, 0.05, 0.3}) {
          ASSERT_NO_FATAL_FAILURE(
              expect_closest(geometry, *mesh, on_m + height_m * edge.normal[0]));
          ASSERT_NO_FATAL_FAILURE(expect_closest(geometry, *mesh, on_m + height_m * Vec3(0, 0, 1)));
        }
      }
    }
  }
}

TEST(StaticGeometry, AConvexIsMetFromOutsideOnly) {
  for (std::uint64_t part = 300; part < 310; ++part) {
    random::Stream stream = stream_of(part);
    std::vector<Vec3> points_m;
    for (int i = 0; i < 12; ++i)
      points_m.push_back(vector_between(stream, -1, 1));
    const auto hull = std::make_shared<const ConvexPolyhedron>(convex_hull(points_m).value());
    Raw raw{.vertices_m = {hull->vertices_m().begin(), hull->vertices_m().end()}, .triangles = {}};
    for (const Face& face : hull->faces()) {
      const auto sides = hull->sides_of(face);
      for (std::size_t i = 1; i + 1 < sides.size(); ++i)
        raw.triangles.push_back({sides[0].vertex, sides[i].vertex, sides[i + 1].vertex});
    }
    const auto mesh = mesh_of(raw, MeshClosure::closed);
    Scene scene = scene_of(mesh);
    scene.meshes.clear();
    scene.convexes = {{.name = "hull", .polyhedron = hull}};
    const StaticGeometry geometry(scene);
    for (int i = 0; i < 300; ++i) {
      const Vec3 p = vector_between(stream, -1.5, 1.5);
      if (const std::string* solid = geometry.solid_at(p)) {
        EXPECT_EQ(*solid, "convex 'hull'");
        EXPECT_EQ(closest_feature(geometry, p).feature, k_none);
        continue;
      }
      ASSERT_NO_FATAL_FAILURE(expect_closest(geometry, *mesh, p));
    }
  }
}

TEST(StaticGeometry, PiecesAreTheTrianglesAndStayWhenMoved) {
  random::Stream stream = stream_of(400);
  const auto mesh = open_mesh(sheet(5, 0.1, 0.1, stream));
  Scene scene = scene_of(mesh);
  scene.contacts = ContactTable(2);
  scene.planes = {{.name = "", .outside = {.normal = {0, 0, 1}, .offset_m = -1}}};
  scene.meshes[0].material = {1};
  StaticGeometry first(scene);
  const StaticGeometry geometry = std::move(first);
  ASSERT_EQ(geometry.piece_count(), 1 + mesh->triangles().size());
  for (std::uint32_t t = 0; t < mesh->triangles().size(); ++t) {
    const MovingPiece& piece = geometry.piece({t + 1});
    ASSERT_EQ(piece.view->vertex_count, 3);
    EXPECT_TRUE(std::isinf(piece.reach_m));
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(piece.view->vertices_m[k], mesh->vertices_m()[mesh->triangles()[t][k]]);
    EXPECT_EQ(piece.view->faces[0].normal, mesh->faces()[t].normal);
    EXPECT_EQ(geometry.name_of_piece({t + 1}), "mesh 'it'");
    EXPECT_EQ(geometry.material_of_piece({t + 1}), MaterialId{1});
  }
  EXPECT_EQ(geometry.name_of_piece({0}), "plane 0");
  EXPECT_EQ(geometry.name_of_feature({1}), "mesh 'it'");
  EXPECT_EQ(geometry.material_of_feature({1}), MaterialId{1});
  // If no body can meet a feature, the feature is not built.
  Scene spheres = scene;
  spheres.bodies.pop_back();
  EXPECT_EQ(StaticGeometry(spheres).piece_count(), 1U);
  EXPECT_EQ(StaticGeometry(spheres).feature_count(), geometry.feature_count());
  Scene cubes = scene;
  cubes.bodies.erase(cubes.bodies.begin());
  EXPECT_EQ(StaticGeometry(cubes).feature_count(), 1U);
}

TEST(StaticGeometry, ErrorsNameTheMesh) {
  random::Stream stream = stream_of(500);
  Raw raw = sheet(2, 0.1, 0.1, stream);
  const Scene good = scene_of(open_mesh(raw));
  EXPECT_FALSE(error_of(good));
  const auto message_of = [](const Scene& scene) {
    const auto error = error_of(scene);
    return error ? error->message : "";
  };
  Scene scene = good;
  scene.meshes.push_back({.name = "funnel", .mesh = nullptr});
  EXPECT_THAT(message_of(scene), ::testing::MatchesRegex("mesh 'funnel': .*no triangles"));
  scene = good;
  scene.meshes[0].material = {3};
  EXPECT_THAT(message_of(scene), ::testing::MatchesRegex("mesh 'it': material is 3, .* 1"));
  for (Vec3& v : raw.vertices_m)
    v *= 1e8;
  scene = scene_of(open_mesh(raw));
  scene.meshes[0].name = "";
  EXPECT_THAT(message_of(scene), ::testing::StartsWith("mesh 0: vertex 1 is at ("));
  scene = good;
  scene.gravity_mps2 = Vec3::Zero();
  scene.period_m = {10, 0, 0};
  EXPECT_THAT(message_of(scene), ::testing::HasSubstr("neither gravity nor static geometry"));
}

TEST(StaticGeometry, AThinPlateIsMetOnItsOwnSides) {
  // One ball falls on a thin plate, and another ball is thrown up from below. Neither ball may
  // collide with the plate's far side.
  const auto hull = [](double low_m, double high_m) {
    std::vector<Vec3> points_m;
    for (const double x : {-0.1, 0.1}) {
      for (const double y : {-0.1, 0.1}) {
        for (const double z : {low_m, high_m})
          points_m.emplace_back(x, y, z);
      }
    }
    return std::make_shared<const ConvexPolyhedron>(convex_hull(points_m).value());
  };
  Scene scene;
  scene.gravity_mps2 = {0, 0, -9.81};
  scene.convexes = {{.name = "plate", .polyhedron = hull(-0.001, 0)}};
  const auto add = [&](double z_m, double speed_mps) {
    scene.bodies.push_back({.name = {},
                            .shape = Sphere{.radius_m = 0.01},
                            .inertia = solid_ball_inertia(1, 0.01),
                            .start = {.pose = {.position_m = {0.03, 0.02, z_m}},
                                      .twist = {.velocity_mps = {0, 0, speed_mps}}}});
  };
  add(0.06, 0);
  add(-0.06, 2);
  for (const Algorithm algorithm : {Algorithm::asynchronous, Algorithm::all_pairs}) {
    SimulationOptions options;
    options.algorithm = algorithm;
    Simulation simulation = Simulation::start(scene, options).value();
    ASSERT_FALSE(simulation.run_until(Tick{} + ticks_after(0.25)));
    EXPECT_EQ(simulation.counts().static_collisions, 2U);
    EXPECT_GT(simulation.pose({0}, simulation.now()).position_m.z(), 0.01);
    EXPECT_LT(simulation.pose({1}, simulation.now()).position_m.z(), -0.011);
  }
}

}  // namespace
}  // namespace sleight::physics
