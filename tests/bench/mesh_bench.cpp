// Times on large static meshes. A sphere and a box bounce for ever in a bowl of triangles, 20 mm
// wide, that has dents. All sizes of the mesh have the same middle, which the bodies never leave.
// So the motion, whose hash is verified, doesn't depend on the size.
//
//   - Rows sphere and box time a simulation, in us per collision.
//   - Rows start time the start of a simulation of both bodies.
//   - Rows compare time the start with the history of a scene in which the box starts elsewhere.
//
// Timed simulations use geometry that an earlier one has built. `ratio` is the time divided by the
// time on the smallest mesh, in the same run of the program.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <ctime>
#include <map>
#include <memory>

#include "tests/bench/harness.h"
#include "worker/physics/scene/static_geometries.h"
#include "worker/physics/shape/mass_properties.h"
#include "worker/physics/shape/shapes.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::bench {
namespace {

using namespace physics;

constexpr std::int32_t k_halves[] = {11, 112};  ///< half the squares along a side, by mesh

struct Row {
  const char* name;
  bool sphere, box;
  double duration_s;
  std::uint64_t hash;
};
constexpr Row k_rows[] = {{"sphere", true, false, 40, 0xb00368c4e1be2443U},
                          {"box", false, true, 40, 0xba0ef642bb16a254U},
                          {"start", true, true, 1, 0xecc99fa52a88bac3U},
                          {"compare", true, true, 1, 0xecc99fa52a88bac3U}};

std::shared_ptr<const TriangleMesh> bowl(std::int32_t half) {
  constexpr double k_edge_m = 0.02;
  std::vector<Vec3> vertices_m;
  std::vector<TriangleCorners> triangles;
  const std::uint32_t row = 2 * static_cast<std::uint32_t>(half) + 1;
  for (std::int32_t y = -half; y <= half; ++y) {
    for (std::int32_t x = -half; x <= half; ++x) {
      const double dent = (x * 7 + y * 13 + x * y * 5) % 11 / 11.0;
      const auto a = static_cast<std::uint32_t>(vertices_m.size());
      vertices_m.emplace_back(x * k_edge_m, y * k_edge_m,
                              3 * k_edge_m * k_edge_m * (x * x + y * y) + 0.004 * dent);
      if (x == half || y == half) continue;
      triangles.push_back({a, a + 1, a + row + 1});
      triangles.push_back({a, a + row + 1, a + row});
    }
  }
  return std::make_shared<const TriangleMesh>(
      TriangleMesh::make(vertices_m, triangles, MeshClosure::may_be_open).value());
}

/// All collisions are elastic and without friction.
Scene scene_of(const Row& row, std::int32_t half) {
  Scene scene;
  scene.geometries = std::make_shared<const StaticGeometries>();
  scene.gravity_mps2 = {0, 0, -9.81};
  scene.contacts = ContactTable(1, {.restitution = 1, .friction = 0});
  scene.meshes.push_back({.name = "bowl", .mesh = bowl(half)});
  if (row.sphere)
    scene.bodies.push_back({.name = "sphere",
                            .shape = Sphere{.radius_m = 0.015},
                            .inertia = solid_ball_inertia(0.01, 0.015),
                            .start = {.pose = {.position_m = {0.03, 0.01, 0.08}}, .twist = {}}});
  if (row.box) {
    const std::vector parts{box({0.02, 0.03, 0.024}).value()};
    BodyShape solid = in_body_frame(parts, 1000, InertiaSymmetry::general).value();
    scene.bodies.push_back(
        {.name = "box",
         .shape = std::make_shared<const Compound>(Compound{.parts = std::move(solid.parts)}),
         .inertia = solid.inertia,
         .start = {.pose = {.position_m = {-0.03, 0.02, 0.08}}, .twist = {}}});
  }
  return scene;
}

void run(benchmark::State& state, const Row& row, std::int32_t half) {
  static std::map<const Row*, double> smallest_us;
  const bool is_start = row.sphere && row.box;
  const Tick end = Tick{} + ticks_after(row.duration_s);
  Scene scene = scene_of(row, half);
  Simulation simulation = Simulation::start(scene, {.keep_history = true}).value();
  CHECK(!simulation.run_until(end));
  ResultHash hash;
  for (BodyId body{}; body < scene.bodies.size(); ++body) {
    for (const double place_m : simulation.pose(body, end).position_m)
      hash.add(place_m);
  }
  const bool compares = &row == &k_rows[3];
  const auto history = compares ? simulation.history() : nullptr;
  if (compares) scene.bodies.back().start.pose.position_m.x() += 0.01;
  const double count = is_start ? 1 : static_cast<double>(simulation.counts().static_collisions);
  std::clock_t clocks = 0;
  for (auto _ : state) {
    const std::clock_t begin = std::clock();
    Simulation timed = Simulation::start(scene, {.keep_history = true}, history).value();
    if (!is_start) CHECK(!timed.run_until(end));
    clocks += std::clock() - begin;
  }
  const double us = 1e6 * static_cast<double>(clocks) / CLOCKS_PER_SEC / count /
                    static_cast<double>(state.iterations());
  if (half == k_halves[0]) smallest_us[&row] = us;
  state.counters["us"] = us;
  if (smallest_us.contains(&row)) state.counters["ratio"] = us / smallest_us[&row];
  verify(state, hash.value(), row.hash);
}

[[maybe_unused]] const bool k_added = [] {
  for (const Row& row : k_rows) {
    for (const std::int32_t half : k_halves)
      benchmark::RegisterBenchmark(
          fmt::format("mesh/{}/{}", row.name, 8 * half * half).c_str(),
          [&row, half](benchmark::State& state) { run(state, row, half); });
  }
  return true;
}();

}  // namespace
}  // namespace sleight::bench
