// Times of distances between convex pieces. In scenes of polyhedra, distances take most of the
// time.
//
// Two equal bodies of size 1 tumble past each other in 1,024 steps of 0.005 sizes and 0.02 rad. The
// bodies' distance is never below 0.01. Poses are computed in advance. An item is one distance.
// Cold searches start from scratch at every step. Warm searches start from the last step's
// features.
#include <benchmark/benchmark.h>

#include <vector>

#include "common/math/elementary.h"
#include "common/math/rotation.h"
#include "tests/bench/harness.h"
#include "worker/physics/distance/closest_points.h"
#include "worker/physics/shape/shapes.h"

namespace sleight::bench {
namespace {

using physics::Closest;
using physics::PlacedPose;
using physics::Vec3;

constexpr int k_steps = 1024;

struct Step {
  PlacedPose a;
  PlacedPose b;
};

// A turns in place. B turns faster and passes A, at the least distance that the bodies' radii
// allow.
std::vector<Step> passage(const physics::ConvexPolyhedron& body) {
  std::vector<Step> steps;
  const auto pose = [](const Vec3& rotation_rad, const Vec3& position_m) {
    return PlacedPose{
        .rotation = math::matrix_of(math::quaternion_of_rotation_vector(rotation_rad)),
        .position_m = position_m};
  };
  for (int i = 0; i < k_steps; ++i) {
    const double s = 0.005 * (i - k_steps / 2);
    steps.push_back({.a = pose({0.02 * i, 0.1, 0.2}, {0, 0, 0}),
                     .b = pose({0.3, 0.012 * i, 0.016 * i},
                               {0.3 * math::sin(s), 0.2 * s, 2 * body.r_outer_m() + 0.01})});
  }
  return steps;
}

void add(ResultHash& hash, const Closest& result) {
  hash.add(result.gap_m);
  for (const double x : {result.normal.x(), result.normal.y(), result.normal.z()})
    hash.add(x);
}

void cold(benchmark::State& state, const physics::ConvexPolyhedron& body, std::uint64_t expected) {
  const std::vector<Step> steps = passage(body);
  const physics::ConvexView view = body.view();
  ResultHash hash;
  for (const Step& step : steps)
    add(hash, physics::closest_cold(view, step.a, view, step.b));
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(physics::closest_cold(view, steps[i].a, view, steps[i].b).gap_m);
    i = (i + 1) % k_steps;
  }
  state.SetItemsProcessed(state.iterations());
  verify(state, hash.value(), expected);
}

void warm(benchmark::State& state, const physics::ConvexPolyhedron& body, std::uint64_t expected) {
  const std::vector<Step> steps = passage(body);
  const physics::ConvexView view = body.view();
  ResultHash hash;
  physics::SeparationCache cache;
  for (const Step& step : steps)
    add(hash, physics::closest_warm(view, step.a, view, step.b, cache));
  // Go through the steps back and forth, so that bodies never jump.
  std::size_t i = 0;
  bool back = false;
  cache = {};
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        physics::closest_warm(view, steps[i].a, view, steps[i].b, cache).gap_m);
    if (i == (back ? 0 : k_steps - 1)) back = !back;
    i = back ? i - 1 : i + 1;
  }
  state.SetItemsProcessed(state.iterations());
  verify(state, hash.value(), expected);
}

void cold_cube(benchmark::State& state) {
  cold(state, physics::cube(1).value(), 0x0e7d833d3a89f374U);
}
BENCHMARK(cold_cube)->Name("distance/cold/cube");

void warm_cube(benchmark::State& state) {
  warm(state, physics::cube(1).value(), 0x0e7d833d3a89f374U);
}
BENCHMARK(warm_cube)->Name("distance/warm/cube");

void cold_icosphere(benchmark::State& state) {
  cold(state, physics::icosphere(0.5, 1).value(), 0x34c234313ee93de7U);
}
BENCHMARK(cold_icosphere)->Name("distance/cold/icosphere42");

void warm_icosphere(benchmark::State& state) {
  warm(state, physics::icosphere(0.5, 1).value(), 0x34c234313ee93de7U);
}
BENCHMARK(warm_icosphere)->Name("distance/warm/icosphere42");

}  // namespace
}  // namespace sleight::bench
