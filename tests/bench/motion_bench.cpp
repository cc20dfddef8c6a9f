// Measures the time to evaluate free flight. Every search and bounding volume needs free flight.
#include <benchmark/benchmark.h>

#include <array>
#include <vector>

#include "common/random/stream.h"
#include "tests/bench/harness.h"
#include "worker/physics/motion/motion_bounds.h"
#include "worker/physics/motion/rotation_track.h"

namespace sleight::bench {
namespace {

using namespace physics;

FreeFlight thrown(std::uint64_t i) {
  random::Stream stream({.seed = 1, .purpose = random::Purpose::prior}, i);
  const auto within = [&stream](double size) { return size * (2 * stream.uniform() - 1); };
  FreeFlight flight;
  for (int axis = 0; axis < 3; ++axis) {
    flight.position_m[axis] = within(1);
    flight.velocity_mps[axis] = within(3);
    flight.angular_velocity_radps[axis] = within(30);
  }
  flight.acceleration_mps2 = Vec3(0, 0, -9.81);
  flight.orientation = math::quaternion_of_rotation_vector(Vec3(within(1), within(1), within(1)));
  return flight;
}

Inertia inertia_of(InertiaSymmetry symmetry) {
  switch (symmetry) {
    case InertiaSymmetry::spherical:
      return {.mass_kg = 1, .principal_kgm2 = Vec3(1, 1, 1), .symmetry = symmetry};
    case InertiaSymmetry::axial:
      return {.mass_kg = 1, .principal_kgm2 = Vec3(1, 1, 1.6), .symmetry = symmetry};
    case InertiaSymmetry::general:
      break;
  }
  return {.mass_kg = 1, .principal_kgm2 = Vec3(1, 1.6, 2.1), .symmetry = symmetry};
}

/// Evaluates the orientation every `apart` ticks during a flight of one second.
void orientations(benchmark::State& state, InertiaSymmetry symmetry, TickCount apart,
                  std::uint64_t expected) {
  const Inertia inertia = inertia_of(symmetry);
  const FreeFlight flight = thrown(0);
  const Tick end = flight.begin + (TickCount{1} << 30);
  ResultHash hash;
  RotationTrack track(flight, inertia);
  for (Tick t = flight.begin; t < end; t = t + apart) {
    const Quat q = track.orientation_at(t);
    for (const double component : {q.w(), q.x(), q.y(), q.z()})
      hash.add(component);
  }
  Tick t = end;
  for (auto _ : state) {
    t = t < end ? t + apart : flight.begin;
    benchmark::DoNotOptimize(track.orientation_at(t));
  }
  state.SetItemsProcessed(state.iterations());
  verify(state, hash.value(), expected);
}

/// At this spacing in time, successive orientations differ by about 0.03 rad, as in a search.
constexpr TickCount k_near = TickCount{1} << 20;
/// At this spacing in time, each evaluation is in another step of a general body's motion.
constexpr TickCount k_far = TickCount{1} << 23;

void spherical(benchmark::State& state) {
  orientations(state, InertiaSymmetry::spherical, k_near, 0x08dbe37bf1ae49d9U);
}
BENCHMARK(spherical)->Name("motion/spherical/orientation");

void axial(benchmark::State& state) {
  orientations(state, InertiaSymmetry::axial, k_near, 0x10a4d40990217501U);
}
BENCHMARK(axial)->Name("motion/axial/orientation");

void general(benchmark::State& state) {
  orientations(state, InertiaSymmetry::general, k_near, 0x8a7f0f14faed864bU);
}
BENCHMARK(general)->Name("motion/general/orientation");

void general_step(benchmark::State& state) {
  orientations(state, InertiaSymmetry::general, k_far, 0xab4a4399a509b5f7U);
}
BENCHMARK(general_step)->Name("motion/general/step");

constexpr std::size_t k_flights = 64;

std::vector<FreeFlight> flights() {
  std::vector<FreeFlight> result;
  for (std::uint64_t i = 0; i < k_flights; ++i)
    result.push_back(thrown(i));
  return result;
}

void add(ResultHash& hash, const Box& box) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    hash.add(static_cast<double>(box.low_m[axis]));
    hash.add(static_cast<double>(box.high_m[axis]));
  }
}

void box(benchmark::State& state) {
  const std::vector<FreeFlight> all = flights();
  const auto box_of = [&all](std::size_t i) {
    return path_box(all[i % k_flights], 0.1, Tick{1 << 20}, Tick{1 << 28});
  };
  ResultHash hash;
  for (std::size_t i = 0; i < k_flights; ++i)
    add(hash, box_of(i));
  std::size_t i = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(box_of(i++));
  state.SetItemsProcessed(state.iterations());
  verify(state, hash.value(), 0xdf1c7ef23c7a964cU);
}
BENCHMARK(box)->Name("motion/box");

void exit_of_box(benchmark::State& state) {
  const std::vector<FreeFlight> all = flights();
  std::vector<Box> boxes;
  for (const FreeFlight& flight : all)
    boxes.push_back(path_box(flight, 0.11, Tick{1 << 20}, Tick{1 << 28}));
  const auto exit_at = [&](std::size_t i) {
    return exit_tick(boxes[i % k_flights], all[i % k_flights], 0.1, Tick{1 << 24});
  };
  ResultHash hash;
  for (std::size_t i = 0; i < k_flights; ++i)
    hash.add(static_cast<std::uint64_t>(exit_at(i).value));
  std::size_t i = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(exit_at(i++));
  state.SetItemsProcessed(state.iterations());
  verify(state, hash.value(), 0xafe23745371dc61dU);
}
BENCHMARK(exit_of_box)->Name("motion/exit_tick");

}  // namespace
}  // namespace sleight::bench
