#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>

#include "tests/scenes/shared/scenes.h"
#include "tests/support/property.h"
#include "tests/unit/worker/physics/scene/random_meshes.h"
#include "worker/physics/scene/static_geometry.h"
#include "worker/physics/scene/static_regions.h"

namespace sleight::physics {
namespace {

using testing::Raw;
using testing::vector_between;

constexpr double k_radius_m = 0.05;

std::uint64_t mesh_count() {
  return property::long_run() ? 8000 : 80;
}
constexpr int k_moves = 12;

double between(random::Stream& stream, double low, double high) {
  return low + (high - low) * stream.uniform();
}

/// A mesh whose vertices move. The scene also has another mesh, a polyhedron and a plane.
struct Subject {
  Raw raw;
  MeshClosure closure = MeshClosure::may_be_open;
  double slack_m = 0;

  std::shared_ptr<TriangleMesh> mesh() const {
    return std::make_shared<TriangleMesh>(
        TriangleMesh::make(raw.vertices_m, raw.triangles, closure).value());
  }
  Scene scene(std::shared_ptr<const TriangleMesh> mesh) const {
    Scene scene = scenes::tray(2, 1).scene;
    scene.bodies.resize(1);
    scene.bodies[0].shape = Sphere{.radius_m = k_radius_m};
    scene.planes = {{.name = "low", .outside = {.normal = {0, 0, 1}, .offset_m = -2}}};
    scene.convexes = scenes::marbles(1, 1).scene.convexes;
    scene.meshes.push_back({.name = "it", .mesh = std::move(mesh), .slack_m = slack_m});
    return scene;
  }
};

Subject subject_of(std::uint64_t n, random::Stream& stream) {
  Subject subject{.raw = n % 4 == 0 ? testing::sheet(5, 0.2, 0.1, stream)
                                    : testing::star(stream, n % 4 == 1 ? 0 : 0.4)};
  if (n % 4 != 0) subject.closure = MeshClosure::closed;
  if (n % 4 == 3) {
    // A hollow in a solid.
    for (TriangleCorners& corners : subject.raw.triangles)
      std::swap(corners[0], corners[1]);
  }
  if (n / 4 % 3 != 0) subject.slack_m = n / 4 % 3 == 1 ? 0.01 : 0.1;
  const Vec3 shift_m = vector_between(stream, -0.5, 0.5);
  for (Vec3& vertex_m : subject.raw.vertices_m)
    vertex_m += shift_m;
  return subject;
}

std::vector<VertexMove> random_moves(const Raw& raw, random::Stream& stream) {
  const auto count = static_cast<std::uint32_t>(raw.vertices_m.size());
  std::vector<VertexMove> moves;
  const auto all = [&](const auto& place) {
    for (std::uint32_t v = 0; v < count; ++v)
      moves.push_back({v, place(raw.vertices_m[v])});
  };
  const auto some = [&](const auto& place) {
    for (auto k = 1 + stream.bits() % 6; k > 0; --k) {
      const auto v = static_cast<std::uint32_t>(stream.bits() % count);
      moves.push_back({v, place(raw.vertices_m[v])});
    }
  };
  switch (stream.bits() % 9) {
    case 0:  // too little to come near a limit
      some([&](const Vec3& p) -> Vec3 { return p + vector_between(stream, -1e-6, 1e-6); });
      break;
    case 1:
    case 2:
      some([&](const Vec3& p) -> Vec3 { return p + vector_between(stream, -0.008, 0.008); });
      break;
    case 3:  // beyond any slack
      some([&](const Vec3& p) -> Vec3 { return p + vector_between(stream, -0.15, 0.15); });
      break;
    case 4: {  // into one plane: edges become flat or stop being flat
      const double z_m = raw.vertices_m[stream.bits() % count].z();
      some([&](const Vec3& p) { return Vec3(p.x(), p.y(), z_m); });
      break;
    }
    case 5: {  // borders depend on the size of the whole mesh
      const double scale = between(stream, 0.5, 1.2);
      all([&](const Vec3& p) -> Vec3 { return scale * p; });
      break;
    }
    case 6: {  // a small change of size
      const double scale = between(stream, 0.999, 1.001);
      all([&](const Vec3& p) -> Vec3 { return scale * p; });
      break;
    }
    case 7:  // inside out
      all([&](const Vec3& p) { return Vec3(-p.x(), p.y(), p.z()); });
      break;
    default:  // no move, or moves to the same place
      if (stream.bits() % 2 == 0) some([&](const Vec3& p) { return p; });
  }
  return moves;
}

void expect_equal_features(const StaticGeometry& used, const StaticGeometry& fresh) {
  ASSERT_EQ(used.feature_count(), fresh.feature_count());
  for (FeatureId i{}; i < fresh.feature_count(); ++i) {
    const SphereFeature& a = used.feature(i);
    const SphereFeature& b = fresh.feature(i);
    ASSERT_EQ(a.kind, b.kind) << i;
    ASSERT_EQ(a.point_m, b.point_m) << i;
    ASSERT_EQ(a.direction, b.direction) << i;
    ASSERT_EQ(a.regions_begin, b.regions_begin) << i;
    ASSERT_EQ(a.regions_end, b.regions_end) << i;
    for (std::size_t k = 0; k < used.sides(a).size(); ++k) {
      ASSERT_EQ(used.sides(a)[k].space.normal, fresh.sides(b)[k].space.normal) << i;
      ASSERT_EQ(used.sides(a)[k].space.offset_m, fresh.sides(b)[k].space.offset_m) << i;
      ASSERT_EQ(used.sides(a)[k].strict, fresh.sides(b)[k].strict) << i;
    }
    ASSERT_EQ(used.name_of_feature(i), fresh.name_of_feature(i));
  }
}

/// Corners of each mesh feature, in the order of static_geometry.h, invariant 1.
std::vector<std::vector<Vec3>> corners_of_features(const TriangleMesh& mesh, bool closed) {
  std::vector<std::vector<Vec3>> corners_m;
  const auto vertices_m = mesh.vertices_m();
  for (const TriangleCorners& t : mesh.triangles()) {
    for (int side = 0; side < (closed ? 1 : 2); ++side)
      corners_m.push_back({vertices_m[t[0]], vertices_m[t[1]], vertices_m[t[2]]});
  }
  for (const MeshEdge& edge : mesh.edges())
    corners_m.push_back({vertices_m[edge.vertex[0]], vertices_m[edge.vertex[1]]});
  for (const Vec3& vertex_m : vertices_m)
    corners_m.push_back({vertex_m});
  return corners_m;
}

/// Least distance between the corners' box and the centre's range. 0 if they overlap.
double distance_m(const CentreRange& centre, const std::vector<Vec3>& corners_m) {
  double square = 0;
  for (int axis = 0; axis < 3; ++axis) {
    double low = corners_m[0][axis];
    double high = low;
    for (const Vec3& corner_m : corners_m) {
      low = std::min(low, corner_m[axis]);
      high = std::max(high, corner_m[axis]);
    }
    const double gap = std::max({0.0, low - centre.middle_m[axis] - centre.half_m[axis],
                                 centre.middle_m[axis] - centre.half_m[axis] - high});
    square += gap * gap;
  }
  return std::sqrt(square);
}

struct Nearness {
  std::uint64_t found = 0;
  std::uint64_t differ = 0;
};

/// Compares features near random boxes. Because of slack, `used` may have more features than
/// `fresh`, but only features out of reach.
void expect_near(const StaticGeometry& used, const StaticGeometry& fresh, const TriangleMesh& mesh,
                 bool closed, bool same_boxes, random::Stream& stream, Nearness& tally) {
  const auto corners_m = corners_of_features(mesh, closed);
  const auto first = fresh.feature_count() - static_cast<std::uint32_t>(corners_m.size());
  std::vector<StaticId> of_used;
  std::vector<StaticId> of_fresh;
  for (int i = 0; i < 12; ++i) {
    const Vec3 middle_m = mesh.vertices_m()[stream.bits() % mesh.vertices_m().size()] +
                          vector_between(stream, -0.12, 0.12);
    Box box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double half_m = k_radius_m * between(stream, 1, 3);
      box.low_m[axis] = static_cast<float>(middle_m[static_cast<int>(axis)] - half_m);
      box.high_m[axis] = static_cast<float>(middle_m[static_cast<int>(axis)] + half_m);
    }
    of_used.clear();
    of_fresh.clear();
    used.features_near(box, k_radius_m, of_used);
    fresh.features_near(box, k_radius_m, of_fresh);
    ASSERT_TRUE(std::ranges::is_sorted(of_used));
    const CentreRange centre(box, k_radius_m);
    for (FeatureId f{}; f < fresh.feature_count(); ++f) {
      const bool in_used = std::ranges::binary_search(of_used, StaticId{f});
      const bool in_fresh = std::ranges::binary_search(of_fresh, StaticId{f});
      tally.found += in_fresh ? 1 : 0;
      tally.differ += in_used != in_fresh ? 1 : 0;
      if (f < first || same_boxes) {
        ASSERT_EQ(in_used, in_fresh) << f;
      }
      if (f < first) continue;
      const bool in_reach = distance_m(centre, corners_m[f - first]) <= centre.reach_m;
      ASSERT_EQ(in_used && in_reach, in_reach && fresh.may_meet(f, centre)) << f;
      if (in_used != in_fresh) {
        ASSERT_FALSE(in_reach) << f;
      }
    }
  }
}

/// Compares both geometries at points near the mesh and far from it.
void expect_same_solids(const StaticGeometry& used, const StaticGeometry& fresh,
                        const TriangleMesh& mesh, random::Stream& stream) {
  for (int i = 0; i < 30; ++i) {
    const Vec3& vertex_m = mesh.vertices_m()[stream.bits() % mesh.vertices_m().size()];
    const double far_m = i % 3 == 0 ? 0.02 : i % 3 == 1 ? 1 : 100;
    Vec3 point_m = vertex_m + vector_between(stream, -far_m, far_m);
    point_m.z() = std::max(point_m.z(), -1.9);
    const std::string* a = used.solid_at(point_m);
    const std::string* b = fresh.solid_at(point_m);
    ASSERT_EQ(a == nullptr ? "" : *a, b == nullptr ? "" : *b) << point_m.transpose();
  }
}

bool within(std::span<const Vec3> places_m, std::span<const Vec3> homes_m, double slack_m) {
  for (std::size_t v = 0; v < places_m.size(); ++v) {
    const Vec3 way_m = places_m[v] - homes_m[v];
    if (std::max({std::fabs(way_m.x()), std::fabs(way_m.y()), std::fabs(way_m.z())}) > slack_m)
      return false;
  }
  return slack_m > 0;
}

TEST(Refresh, IsAsNew) {
  // Goal: after vertices move, a refreshed geometry equals a newly built geometry: it has the same
  // features, regions, nearby features and solids. Method: apply every kind of move to sheets,
  // stars and hollows.
  Nearness tally;
  std::uint64_t kinds_changed = 0;
  std::uint64_t refused = 0;
  for (const std::uint64_t n : property::cases(mesh_count())) {
    random::Stream stream({.seed = 31, .purpose = random::Purpose::scene}, n);
    Subject subject = subject_of(n, stream);
    const auto mesh = subject.mesh();
    const Scene scene = subject.scene(mesh);
    const auto place = scene.meshes.size() - 1;
    StaticGeometry used(scene);
    std::vector<Vec3> homes_m = subject.raw.vertices_m;
    for (int i = 0; i < k_moves; ++i) {
      SCOPED_TRACE(::testing::Message() << "mesh " << n << ", move " << i);
      const auto moves = random_moves(subject.raw, stream);
      const std::vector<MeshEdge> before(mesh->edges().begin(), mesh->edges().end());
      if (mesh->move_vertices(moves)) {
        ++refused;
        continue;
      }
      used.refresh(place);
      for (const VertexMove& move : moves)
        subject.raw.vertices_m[move.vertex] = move.position_m;
      for (std::size_t e = 0; e < before.size(); ++e)
        kinds_changed += before[e].kind != mesh->edges()[e].kind ? 1 : 0;
      const bool kept = within(subject.raw.vertices_m, homes_m, subject.slack_m);
      if (!kept) homes_m = subject.raw.vertices_m;
      const StaticGeometry fresh(subject.scene(subject.mesh()));
      ASSERT_NO_FATAL_FAILURE(expect_equal_features(used, fresh));
      ASSERT_NO_FATAL_FAILURE(expect_near(
          used, fresh, *mesh, subject.closure == MeshClosure::closed, !kept, stream, tally));
      ASSERT_NO_FATAL_FAILURE(expect_same_solids(used, fresh, *mesh, stream));
    }
  }
  if (!property::all_cases()) return;
  std::printf(
      "%llu found, %llu more or less; %llu edges changed their kind, %llu moves refused\n",
      static_cast<unsigned long long>(tally.found), static_cast<unsigned long long>(tally.differ),
      static_cast<unsigned long long>(kinds_changed), static_cast<unsigned long long>(refused));
  EXPECT_GT(tally.found, 500 * mesh_count());
  EXPECT_GT(kinds_changed, 10 * mesh_count());
  EXPECT_LT(refused, mesh_count());
}

TEST(Refresh, AFlatSolidIsTurnedInsideOutWithinItsSlack) {
  // Goal: a refresh decides again whether a solid is hollow, unless the slack is too small to
  // change that. Method: mirror thick stars and very flat stars several times. The vertices of the
  // flat stars stay within their slack.
  for (const std::uint64_t n : property::cases(20)) {
    random::Stream stream({.seed = 34, .purpose = random::Purpose::scene}, n);
    const bool is_flat = n % 2 == 1;
    Subject subject{
        .raw = testing::star(stream, 0.4), .closure = MeshClosure::closed, .slack_m = 0.005};
    for (Vec3& vertex_m : subject.raw.vertices_m)
      vertex_m.z() *= is_flat ? 0.001 : 1;
    const auto mesh = subject.mesh();
    ASSERT_EQ(keeps_side(*mesh, subject.slack_m), !is_flat) << n;
    StaticGeometry geometry(subject.scene(mesh));
    const Vec3 far_m(100, 100, 100);
    for (int i = 0; i < 4; ++i) {
      ASSERT_EQ(geometry.solid_at(far_m) != nullptr, i % 2 == 1) << n << ", " << i;
      std::vector<VertexMove> moves;
      for (std::uint32_t v = 0; v < mesh->vertices_m().size(); ++v) {
        const Vec3& p = mesh->vertices_m()[v];
        moves.push_back({v, {p.x(), p.y(), -p.z()}});
      }
      ASSERT_FALSE(mesh->move_vertices(moves));
      geometry.refresh(1);
    }
  }
}

TEST(Refresh, AVolumeThatIsKeptIsKeptByAnyMove) {
  // Goal: if keeps_side() returns true, no move of vertices within the slack turns a mesh inside
  // out. For many stars, keeps_side() returns true. Method: move each vertex of a star to a corner
  // of its slack.
  int kept = 0;
  for (const std::uint64_t n : property::cases(200)) {
    random::Stream stream({.seed = 35, .purpose = random::Purpose::scene}, n);
    const Raw raw = testing::star(stream, 0.4);
    const auto mesh = Subject{.raw = raw, .closure = MeshClosure::closed}.mesh();
    const double slack_m = 0.2 * stream.uniform();
    if (!keeps_side(*mesh, slack_m)) continue;
    ++kept;
    const bool hollow = is_hollow(*mesh);
    for (int i = 0; i < 10; ++i) {
      std::vector<VertexMove> moves;
      for (std::uint32_t v = 0; v < raw.vertices_m.size(); ++v) {
        Vec3 place_m = raw.vertices_m[v];
        for (int axis = 0; axis < 3; ++axis) {
          const double inwards = place_m[axis] < 0 ? 1 : -1;
          const double sign = i == 0 ? inwards : (stream.bits() % 2 == 0 ? 1 : -1);
          place_m[axis] += sign * slack_m;
        }
        moves.push_back({v, place_m});
      }
      if (!mesh->move_vertices(moves)) {
        ASSERT_EQ(is_hollow(*mesh), hollow) << n << ", " << i;
      }
    }
  }
  if (!property::all_cases()) return;
  EXPECT_GT(kept, 20);
  EXPECT_LT(kept, 180);
}

// ---- solids -------------------------------------------------------------------------------------

/// Reference: the distance from a star's middle to the star's surface in one direction.
double surface_m(const TriangleMesh& mesh, const Vec3& middle_m, const Vec3& way) {
  double furthest_m = 0;
  for (const TriangleCorners& t : mesh.triangles()) {
    const Vec3 a = mesh.vertices_m()[t[0]] - middle_m;
    const Vec3 b = mesh.vertices_m()[t[1]] - middle_m;
    const Vec3 c = mesh.vertices_m()[t[2]] - middle_m;
    const double volume = math::dot(a, math::cross(b, c));
    const double u = math::dot(way, math::cross(b, c)) / volume;
    const double v = math::dot(way, math::cross(c, a)) / volume;
    const double w = math::dot(way, math::cross(a, b)) / volume;
    // On the triangle's plane, u + v + w = 1 for a point u a + v b + w c.
    if (u >= 0 && v >= 0 && w >= 0) furthest_m = std::max(furthest_m, 1 / (u + v + w));
  }
  return furthest_m;
}

TEST(Solids, AreWhereTheMeshIs) {
  // Goal: solid_at() finds exactly the points inside a solid, even for points far from the mesh. If
  // the mesh is inside out, everything but the hollow is solid. Method: use stars, whose surface is
  // known in each direction from the middle. Test points slightly inside and slightly outside the
  // surface, at the middle and far away.
  for (const std::uint64_t n : property::cases(20)) {
    random::Stream stream({.seed = 33, .purpose = random::Purpose::scene}, n);
    Raw raw = testing::star(stream, 0.4);
    const bool hollow = n % 2 == 1;
    const Vec3 middle_m = vector_between(stream, -3, 3);
    for (Vec3& vertex_m : raw.vertices_m)
      vertex_m += middle_m;
    if (hollow) {
      for (TriangleCorners& corners : raw.triangles)
        std::swap(corners[0], corners[1]);
    }
    const auto mesh = testing::mesh_of(raw, MeshClosure::closed);
    Scene scene = scenes::rain(1, 1).scene;
    scene.planes.clear();
    scene.convexes.clear();
    scene.meshes = {{.name = "it", .mesh = mesh, .slack_m = n % 4 < 2 ? 0 : 0.1}};
    const StaticGeometry geometry(scene);
    for (int i = 0; i < 200; ++i) {
      const Vec3 way = math::normalized(vector_between(stream, -1, 1));
      const double border_m = surface_m(*mesh, middle_m, way);
      for (const double at_m : {0.0, 0.5 * border_m, border_m - 1e-9, border_m + 1e-9,
                                border_m + 0.3, border_m + 30, border_m + 1e6}) {
        const Vec3 point_m = middle_m + at_m * way;
        ASSERT_EQ(geometry.solid_at(point_m) != nullptr, (at_m < border_m) != hollow)
            << "mesh " << n << ", " << at_m << " m from its middle, border at " << border_m;
      }
    }
  }
}

}  // namespace
}  // namespace sleight::physics
