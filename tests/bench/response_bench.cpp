// Time to compute an impact, as in every collision of a simulation.
#include <benchmark/benchmark.h>

#include <cstddef>
#include <vector>

#include "common/random/angular_distributions.h"
#include "common/random/stream.h"
#include "tests/bench/harness.h"
#include "worker/physics/response/rigid_impact.h"
#include "worker/physics/response/sphere_impact.h"

namespace sleight::bench {
namespace {

using physics::ImpactOutput;

constexpr std::size_t k_cases = 1024;

random::Stream case_stream(std::uint64_t iteration) {
  return random::Stream({.seed = 3, .purpose = random::Purpose::prior}, iteration);
}

physics::Twist random_twist(random::Stream& stream) {
  const random::UniformDirection3 direction;
  physics::Twist twist;
  twist.velocity_mps = direction.draw(stream);
  twist.angular_velocity_radps = 10 * direction.draw(stream);
  return twist;
}

/// Applies a law to the cases in turn. The hash covers one pass.
template <class Input, class Law>
void run(benchmark::State& state, const std::vector<Input>& cases, const Law& law,
         std::uint64_t expected) {
  ResultHash hash;
  for (const Input& input : cases) {
    const ImpactOutput out = law(input);
    for (Eigen::Index i = 0; i < 3; ++i) {
      hash.add(out.a.velocity_mps[i]);
      hash.add(out.a.angular_velocity_radps[i]);
      hash.add(out.b.velocity_mps[i]);
      hash.add(out.b.angular_velocity_radps[i]);
    }
  }
  std::size_t next = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(law(cases[next]));
    next = (next + 1) % k_cases;
  }
  state.SetItemsProcessed(state.iterations());
  verify(state, hash.value(), expected);
}

/// Two equal balls of 1 cm that approach.
std::vector<physics::SphereImpactInput> sphere_cases(double friction) {
  std::vector<physics::SphereImpactInput> cases;
  for (std::size_t i = 0; i < k_cases; ++i) {
    random::Stream stream = case_stream(i);
    physics::SphereImpactInput input;
    input.mass_a = physics::solid_sphere_mass(0.005, 0.01);
    input.mass_b = input.mass_a;
    input.a = random_twist(stream);
    input.b = random_twist(stream);
    input.normal = random::UniformDirection3{}.draw(stream);
    const physics::Vec3 apart_mps = input.b.velocity_mps - input.a.velocity_mps;
    if (math::dot(apart_mps, input.normal) > 0) input.normal = -input.normal;
    input.law = {.restitution = friction == 0 ? 1.0 : 0.7, .friction = friction};
    cases.push_back(input);
  }
  return cases;
}

void sphere(benchmark::State& state) {
  run(state, sphere_cases(0.3), physics::sphere_impact, 0x7459c5b5ed16bab5U);
}
BENCHMARK(sphere)->Name("response/sphere");

/// Velocities only, as in a gas of hard spheres.
void sphere_velocities(benchmark::State& state) {
  const std::vector<physics::SphereImpactInput> cases = sphere_cases(0);
  const auto law = [&](const physics::SphereImpactInput& input) {
    ImpactOutput out{.a = input.a, .b = input.b};
    physics::frictionless_sphere_impact(input.normal, 200, 200, 1, 0, out.a.velocity_mps,
                                        out.b.velocity_mps);
    return out;
  };
  ResultHash hash;
  for (const physics::SphereImpactInput& input : cases) {
    const ImpactOutput out = law(input);
    hash.add(out.a.velocity_mps.x());
    hash.add(out.b.velocity_mps.z());
  }
  std::vector<physics::Vec3> velocities;
  std::vector<physics::Vec3> normals;
  for (const physics::SphereImpactInput& input : cases) {
    velocities.push_back(input.a.velocity_mps);
    velocities.push_back(input.b.velocity_mps);
    normals.push_back(input.normal);
  }
  std::size_t next = 0;
  for (auto _ : state) {
    physics::Vec3 a = velocities[2 * next];
    physics::Vec3 b = velocities[2 * next + 1];
    benchmark::DoNotOptimize(
        physics::frictionless_sphere_impact(normals[next], 200, 200, 1, 0, a, b));
    benchmark::DoNotOptimize(a);
    benchmark::DoNotOptimize(b);
    next = (next + 1) % k_cases;
  }
  state.SetItemsProcessed(state.iterations());
  verify(state, hash.value(), 0x91e9cd190f160844U);
}
BENCHMARK(sphere_velocities)->Name("response/sphere_velocities");

void sphere_frictionless(benchmark::State& state) {
  run(state, sphere_cases(0), physics::sphere_impact, 0x57b7f1bca94e6f93U);
}
BENCHMARK(sphere_frictionless)->Name("response/sphere_frictionless");

/// Boxes of 2 x 3 x 5 cm that meet near their corners: two boxes, or a box and the floor.
std::vector<physics::RigidImpactInput> rigid_cases(bool on_floor) {
  const double mass_kg = 0.03;
  const physics::Vec3 sides_m(0.02, 0.03, 0.05);
  const physics::Vec3 squares = sides_m.cwiseProduct(sides_m);
  const physics::Vec3 moments = mass_kg / 12 *
                                physics::Vec3(squares.y() + squares.z(), squares.x() + squares.z(),
                                              squares.x() + squares.y());
  const physics::RigidMass mass =
      physics::rigid_mass({.mass_kg = mass_kg, .principal_kgm2 = moments});
  std::vector<physics::RigidImpactInput> cases;
  for (std::size_t i = 0; i < k_cases; ++i) {
    random::Stream stream = case_stream(i);
    const random::UniformDirection3 direction;
    physics::RigidImpactInput input;
    for (physics::RigidImpactBody* body : {&input.b, &input.a}) {
      body->mass = mass;
      body->pose.position_m = 0.03 * direction.draw(stream);
      body->pose.orientation = random::UniformRotation{}.draw(stream);
      body->twist = random_twist(stream);
      if (on_floor) break;
    }
    input.normal = direction.draw(stream);
    input.law = {.restitution = 0.5, .friction = 0.4};
    // Reverse the normal if the bodies separate along it.
    if (rigid_impact(input).regime == physics::ImpactRegime::separating) {
      input.normal = -input.normal;
    }
    cases.push_back(input);
  }
  return cases;
}

void rigid(benchmark::State& state) {
  run(state, rigid_cases(false), physics::rigid_impact, 0xbf12cd79b3a84107U);
}
BENCHMARK(rigid)->Name("response/rigid");

void rigid_on_floor(benchmark::State& state) {
  run(state, rigid_cases(true), physics::rigid_impact, 0x724e7d6f9271925fU);
}
BENCHMARK(rigid_on_floor)->Name("response/rigid_on_floor");

}  // namespace
}  // namespace sleight::bench
