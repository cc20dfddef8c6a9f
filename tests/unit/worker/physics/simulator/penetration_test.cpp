// Tests that bodies don't overlap. The test's geometry is independent of the simulator.
//
// A collision is the first tick at which a gap is at most k_touch_m = 1e-7 m. So no clearance
// should fall below 0 by more than the rounding of this test's geometry. While bodies touch without
// a collision, they may sink into each other at the speed k_approach_mps, by about 1e-9 m.
#include <gtest/gtest.h>

#include <map>
#include <optional>

#include "tests/support/property.h"
#include "tests/unit/worker/physics/simulator/mixed_scene.h"
#include "tests/unit/worker/physics/simulator/plain_geometry.h"
#include "tests/unit/worker/physics/simulator/recorded_run.h"
#include "tests/unit/worker/physics/simulator/scenes_under_test.h"

namespace sleight::physics {
namespace {

using testing::PlainSolid;
using testing::RecordedRun;

constexpr double k_depth_m = 1e-9;

class Overlaps {
 public:
  explicit Overlaps(const RecordedRun& run)
      : run_(run), shift_(run.scene.bodies.size(), Vec3::Zero()) {
    for (const BodyDescription& body : run.scene.bodies) {
      const auto* sphere = std::get_if<Sphere>(&body.shape);
      reach_m_.push_back(sphere != nullptr
                             ? sphere->radius_m
                             : std::get<std::shared_ptr<const Compound>>(body.shape)->r_outer_m());
    }
    for (const StaticConvex& convex : run.scene.convexes)
      statics_.push_back(testing::solid_at(*convex.polyhedron, {}));
    for (const StaticMesh& mesh : run.scene.meshes) {
      for (const TriangleCorners& corners : mesh.mesh->triangles()) {
        const auto vertices_m = mesh.mesh->vertices_m();
        const std::array<Vec3, 3> corners_m{vertices_m[corners[0]], vertices_m[corners[1]],
                                            vertices_m[corners[2]]};
        Triangle triangle{testing::solid_of_triangle(corners_m),
                          (corners_m[0] + corners_m[1] + corners_m[2]) / 3, 0, mesh.name};
        for (const Vec3& corner_m : corners_m)
          triangle.reach_m = std::max(triangle.reach_m, math::norm(corner_m - triangle.centre_m));
        triangles_.push_back(std::move(triangle));
      }
    }
  }

  /// Moves a body away from its recorded place.
  void shift(std::uint32_t body, const Vec3& by_m) { shift_[body] = by_m; }

  /// Returns the least clearance at a tick, between bodies or between a body and static geometry.
  /// `who` names the pair.
  double least(Tick tick, std::string& who) {
    placed_.assign(run_.scene.bodies.size(), {});
    double least_m = 1;
    const auto offer = [&](double clearance_m, std::uint32_t a, const std::string& b) {
      if (clearance_m >= least_m) return;
      least_m = clearance_m;
      who = "body " + std::to_string(a) + " and " + b + " at tick " + std::to_string(tick.value);
    };
    for (std::uint32_t a = 0; a < placed_.size(); ++a) {
      const Segment* segment = run_.recording.segment_at({a}, tick);
      if (segment == nullptr) continue;
      placed_[a].segment = segment;
      placed_[a].place_m = testing::place_at(*segment, tick) + shift_[a];
    }
    for (std::uint32_t a = 0; a < placed_.size(); ++a) {
      if (placed_[a].segment == nullptr) continue;
      for (std::uint32_t b = a + 1; b < placed_.size(); ++b) {
        if (placed_[b].segment == nullptr) continue;
        const Vec3 image_m = nearest_image_m(placed_[a].place_m, placed_[b].place_m);
        const double centres_m = math::norm(placed_[b].place_m + image_m - placed_[a].place_m);
        if (centres_m - reach_m_[a] - reach_m_[b] >= least_m) continue;
        offer(of_pair(a, b, centres_m, tick), a, "body " + std::to_string(b));
      }
      of_statics(a, tick, offer);
    }
    return least_m;
  }

 private:
  struct Placed {
    const Segment* segment = nullptr;
    Vec3 place_m = Vec3::Zero();
    std::vector<PlainSolid> parts;
  };

  Vec3 nearest_image_m(const Vec3& from_m, const Vec3& to_m) const {
    Vec3 shift = Vec3::Zero();
    for (int i = 0; i < 3; ++i) {
      const double period_m = run_.scene.period_m[static_cast<std::size_t>(i)];
      if (period_m > 0) shift[i] = -period_m * std::round((to_m[i] - from_m[i]) / period_m);
    }
    return shift;
  }

  bool is_sphere(std::uint32_t body) const {
    return std::holds_alternative<Sphere>(run_.scene.bodies[body].shape);
  }

  const std::vector<PlainSolid>& parts_of(std::uint32_t body, Tick tick) {
    Placed& placed = placed_[body];
    if (placed.parts.empty()) {
      const BodyDescription& description = run_.scene.bodies[body];
      const Pose pose{placed.place_m, testing::turn_at(*placed.segment, description.inertia, tick)};
      for (const auto& part : std::get<std::shared_ptr<const Compound>>(description.shape)->parts)
        placed.parts.push_back(testing::solid_at(part, pose));
    }
    return placed.parts;
  }

  double of_pair(std::uint32_t a, std::uint32_t b, double centres_m, Tick tick) {
    if (is_sphere(a) && is_sphere(b)) return centres_m - reach_m_[a] - reach_m_[b];
    if (is_sphere(b)) std::swap(a, b);
    double least_m = 1;
    for (const PlainSolid& second : parts_of(b, tick)) {
      if (is_sphere(a)) {
        least_m = std::min(least_m, testing::distance(placed_[a].place_m, second) - reach_m_[a]);
        continue;
      }
      for (const PlainSolid& first : parts_of(a, tick))
        least_m = std::min(least_m, testing::clearance(first, second));
    }
    return least_m;
  }

  template <class Offer>
  void of_statics(std::uint32_t body, Tick tick, const Offer& offer) {
    const Vec3& place_m = placed_[body].place_m;
    for (const StaticPlane& plane : run_.scene.planes) {
      const double height_m =
          math::dot(plane.outside.normal, place_m) - plane.outside.offset_m - reach_m_[body];
      if (is_sphere(body)) {
        offer(height_m, body, plane.name);
      } else if (height_m < 0) {
        for (const PlainSolid& part : parts_of(body, tick)) {
          for (const Vec3& v : part.corners_m)
            offer(math::dot(plane.outside.normal, v) - plane.outside.offset_m, body, plane.name);
        }
      }
    }
    for (std::size_t i = 0; i < statics_.size(); ++i) {
      const std::string& name = run_.scene.convexes[i].name;
      const double centre_m = testing::distance(place_m, statics_[i]) - reach_m_[body];
      if (is_sphere(body)) {
        offer(centre_m, body, name);
      } else if (centre_m < 0) {
        for (const PlainSolid& part : parts_of(body, tick))
          offer(testing::clearance(part, statics_[i]), body, name);
      }
    }
    for (const Triangle& triangle : triangles_) {
      if (math::norm(place_m - triangle.centre_m) > reach_m_[body] + triangle.reach_m) continue;
      if (is_sphere(body)) {
        offer(testing::distance(place_m, triangle.solid) - reach_m_[body], body, triangle.mesh);
      } else {
        for (const PlainSolid& part : parts_of(body, tick))
          offer(testing::clearance(part, triangle.solid), body, triangle.mesh);
      }
    }
  }

  struct Triangle {
    PlainSolid solid;
    Vec3 centre_m;
    double reach_m;
    std::string mesh;
  };

  const RecordedRun& run_;
  std::vector<Triangle> triangles_;  ///< of all meshes
  std::vector<Vec3> shift_;
  std::vector<double> reach_m_;
  std::vector<PlainSolid> statics_;
  std::vector<Placed> placed_;
};

/// Ticks of at most count_max collisions, in ascending order.
std::vector<Tick> collision_ticks(const RecordedRun& run, std::size_t count_max) {
  std::vector<Tick> all;
  for (std::uint32_t body = 0; body < run.scene.bodies.size(); ++body) {
    for (const Recording::Entry& entry : run.recording.segments({body})) {
      if (entry.cause.kind == EventKind::collision) all.push_back(entry.cause.tick);
    }
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  if (all.size() <= count_max) return all;
  std::vector<Tick> some;
  for (std::size_t i = 0; i < count_max; ++i)
    some.push_back(all[i * all.size() / count_max]);
  return some;
}

struct Deepest {
  double clearance_m = 1;
  std::string who;
  void offer(Overlaps& overlaps, Tick tick) {
    std::string name;
    const double found_m = overlaps.least(tick, name);
    if (found_m < clearance_m) *this = {found_m, name};
  }
};

Deepest deepest_of(const RecordedRun& run, std::size_t collisions, int random_ticks,
                   std::uint64_t seed) {
  Overlaps overlaps(run);
  Deepest deepest;
  const Tick end = run.recording.end();
  for (const Tick tick : collision_ticks(run, collisions)) {
    for (const TickCount off : {-1000, -2, -1, 0, 1, 2, 1000})
      deepest.offer(overlaps, std::clamp(tick + off, Tick{}, end));
  }
  random::Stream stream = scenes::stream_of_scene(seed, 1);
  for (int i = 0; i < random_ticks; ++i) {
    deepest.offer(
        overlaps,
        Tick{static_cast<TickCount>(stream.bits() % static_cast<std::uint64_t>(end.value + 1))});
  }
  return deepest;
}

TEST(Penetration, NoSceneHasBodiesThatOverlap) {
  // Goal: bodies never overlap, in any kind of scene. Method: compute clearances at random ticks
  // and at ticks shortly before and after recorded collisions.
  const std::uint64_t scenes = property::long_run() ? 600 : property::of_tier(27, 60);
  std::map<std::string, double> least_m;
  for (const std::uint64_t n : property::cases(scenes)) {
    const testing::TestScene scene = testing::test_scene(n);
    const RecordedRun run = testing::recorded(scene.setting.scene, scene.setting.duration_s);
    ASSERT_EQ(run.error, "") << "scene " << n << ": " << scene.name;
    const Deepest deepest = deepest_of(run, 150, 150, n);
    EXPECT_GT(deepest.clearance_m, -k_depth_m)
        << "scene " << n << ": " << scene.name << ", " << deepest.who;
    const std::string kind = scene.name.substr(0, scene.name.find(' '));
    least_m.try_emplace(kind, 1).first->second =
        std::min(least_m.try_emplace(kind, 1).first->second, deepest.clearance_m);
  }
  if (!property::all_cases()) return;
  for (const auto& [kind, clearance_m] : least_m) {
    std::printf("least clearance of %s: %.3e m\n", kind.c_str(), clearance_m);
    EXPECT_LT(clearance_m, 2 * k_touch_m) << kind << " never came close: nothing was looked at";
  }
}

TEST(Penetration, BodiesOfEveryShapeStayApart) {
  // Goal: bodies of every shape stay apart. The scenes have cases that other scenes lack: spheres
  // that meet polyhedra, bodies of several parts, long boxes, prisms, and spheres at static edges.
  double least_m = 1;
  for (const std::uint64_t seed :
       property::seeds(property::long_run() ? 200 : property::of_tier(3, 12))) {
    const RecordedRun run = testing::recorded(testing::mixed_scene(seed), 0.6);
    ASSERT_EQ(run.error, "") << "mixed scene of seed " << seed;
    EXPECT_GT(run.counts.collisions, 20U) << seed;
    const Deepest deepest = deepest_of(run, 200, 200, seed);
    EXPECT_GT(deepest.clearance_m, -k_depth_m)
        << "mixed scene of seed " << seed << ", " << deepest.who;
    least_m = std::min(least_m, deepest.clearance_m);
  }
  std::printf("least clearance of mixed scenes: %.3e m\n", least_m);
}

TEST(Penetration, RestingBodiesDoNotSink) {
  // Goal: while the grains of a heap bounce by micrometres and come to rest, they don't sink into
  // each other.
  const scenes::Setting setting = scenes::grain_heap(property::long_run() ? 60 : 10, 1);
  const RecordedRun run = testing::recorded(setting.scene, 1.5);
  ASSERT_EQ(run.error, "");
  const Deepest deepest = deepest_of(run, 400, 100, 1);
  EXPECT_GT(deepest.clearance_m, -k_depth_m) << deepest.who;
  std::printf("least clearance of grain_heap: %.3e m\n", deepest.clearance_m);
}

TEST(Penetration, IsSeenWhereBodiesWereShifted) {
  // Goal: the tests above detect an overlap. Method: at the tick of a collision, shift a body by a
  // micrometre. Shift it along each axis, in both directions. At least one of these shifts moves
  // the body more than half a micrometre towards the body that it touches.
  constexpr double k_shift_m = 1e-6;
  for (const std::uint64_t n : {0U, 1U, 2U, 3U, 4U, 5U, 6U, 7U, 8U, 9U}) {
    const testing::TestScene scene = testing::test_scene(n);
    const RecordedRun run = testing::recorded(scene.setting.scene, scene.setting.duration_s);
    ASSERT_EQ(run.error, "");
    std::optional<EventKey> collision;
    for (std::uint32_t body = 0; body < run.scene.bodies.size() && !collision; ++body) {
      for (const Recording::Entry& entry : run.recording.segments({body})) {
        if (entry.cause.kind == EventKind::collision) collision = entry.cause;
      }
    }
    ASSERT_TRUE(collision) << scene.name;
    Overlaps overlaps(run);
    double least_m = 1;
    for (int i = 0; i < 6; ++i) {
      Vec3 by_m = Vec3::Zero();
      by_m[i / 2] = i % 2 == 0 ? k_shift_m : -k_shift_m;
      overlaps.shift(collision->lower, by_m);
      std::string who;
      least_m = std::min(least_m, overlaps.least(collision->tick, who));
    }
    EXPECT_LT(least_m, -0.4 * k_shift_m) << scene.name;
  }
}

TEST(Penetration, PlainGeometryKnowsOverlaps) {
  // Goal: this test's own geometry finds the right clearances in known cases. Method: test two unit
  // cubes face to face and edge to edge, and points in and around a cube.
  const ConvexPolyhedron cube = physics::cube(1).value();
  const PlainSolid fixed = testing::solid_at(cube, {});
  const auto at = [&](const Vec3& place_m, const Quat& turn) {
    return testing::clearance(fixed, testing::solid_at(cube, {place_m, turn}));
  };
  EXPECT_NEAR(at({1.25, 0.3, 0}, Quat::Identity()), 0.25, 1e-15);
  EXPECT_NEAR(at({0.75, 0.3, 0}, Quat::Identity()), -0.25, 1e-15);
  // An edge along y, above the fixed cube's edge along x. The half diagonals reach sqrt(1/2).
  const Quat tilt_x = math::quaternion_of_rotation_vector({std::atan(1.0), 0, 0});
  const Quat tilt_y = math::quaternion_of_rotation_vector({0, std::atan(1.0), 0});
  const PlainSolid lower = testing::solid_at(cube, {{0, 0, 0}, tilt_x});
  const auto crossed = [&](double height_m) {
    return testing::clearance(lower, testing::solid_at(cube, {{0, 0, height_m}, tilt_y}));
  };
  EXPECT_NEAR(crossed(std::sqrt(2.0) + 0.1), 0.1, 1e-14);
  EXPECT_NEAR(crossed(std::sqrt(2.0) - 0.1), -0.1, 1e-14);
  EXPECT_NEAR(testing::distance({0, 0, 0.75}, fixed), 0.25, 1e-15);
  EXPECT_NEAR(testing::distance({0, 0.1, 0.25}, fixed), -0.25, 1e-15);
  EXPECT_NEAR(testing::distance({0.8, 0, 0.9}, fixed), 0.5, 1e-15);
  EXPECT_NEAR(testing::distance({0.7, 0.6, 0.7}, fixed), 0.3, 1e-15);
}

}  // namespace
}  // namespace sleight::physics
