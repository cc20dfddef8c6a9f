// A die of 16 mm comes to rest on a bumpy table. Other engines simulate the same throw for
// comparison (scene "die"). The table is an exact bicubic B-spline. Control points are 21 mm apart,
// and up to 1 mm high or deep.
#include <benchmark/benchmark.h>

#include <memory>
#include <optional>
#include <vector>

#include "common/base/check.h"
#include "common/random/angular_distributions.h"
#include "common/random/distributions.h"
#include "common/random/stream.h"
#include "tests/bench/harness.h"
#include "worker/physics/shape/shapes.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::bench {
namespace {

using namespace physics;

constexpr double k_side_m = 0.016;
constexpr double k_mass_kg = 1200 * k_side_m * k_side_m * k_side_m;
constexpr std::int32_t k_half_points = 12;  ///< the table is 0.5 m wide; flat beyond

/// A fixed random set of control points. Other engines use the same set.
class Bumps final : public SurfaceControls {
 public:
  Bumps() {
    random::Stream stream({.seed = 3, .purpose = random::Purpose::scene}, 0);
    for (double& height_m : heights_m_)
      height_m = random::Uniform{.low = -1e-3, .high = 1e-3}.draw(stream);
  }
  SurfaceControl at(GridIndex index) const override {
    const bool inside = std::abs(index.i) <= k_half_points && std::abs(index.j) <= k_half_points;
    const auto place =
        static_cast<std::size_t>((index.i + k_half_points) * k_side + (index.j + k_half_points));
    return {.height_m = inside ? heights_m_[place] : 0, .restitution = 0.5, .friction = 0.4};
  }
  std::optional<std::vector<GridIndex>> changed_from(const SurfaceControls&) const override {
    return std::nullopt;
  }

 private:
  static constexpr std::int32_t k_side = 2 * k_half_points + 1;
  std::vector<double> heights_m_ = std::vector<double>(k_side * k_side);
};

StartState throw_of(std::uint64_t number) {
  random::Stream stream({.seed = 4, .purpose = random::Purpose::scene}, number);
  const auto normal = [&](double mean, double sd) {
    return random::Normal{.mean = mean, .sd = sd}.draw(stream);
  };
  const auto vector = [&](const Vec3& mean, const Vec3& sd) {
    const double x = normal(mean.x(), sd.x());
    const double y = normal(mean.y(), sd.y());
    return Vec3(x, y, sd.z() > 0 ? normal(mean.z(), sd.z()) : mean.z());
  };
  StartState start;
  start.pose.position_m = vector({-0.15, 0, 0.1}, {0.005, 0.005, 0});
  start.pose.orientation = random::UniformRotation{}.draw(stream);
  start.twist.velocity_mps = vector({0.7, 0, 0}, {0.1, 0.1, 0});
  start.twist.angular_velocity_radps = vector(Vec3::Zero(), {20, 20, 20});
  return start;
}

Scene table() {
  Scene scene;
  scene.gravity_mps2 = {0, 0, -9.81};
  scene.contacts = ContactTable(1, {.restitution = 0.5, .friction = 0.4});
  scene.slow = coarse_slow_contacts_of(k_side_m, 9.81);
  scene.surfaces.push_back(
      {.name = "table", .controls = std::make_shared<Bumps>(), .spacing_m = 0.021});
  auto cube_of_side = cube(k_side_m);
  CHECK(cube_of_side.ok());
  auto shape = std::make_shared<Compound>();
  shape->parts.push_back(std::move(cube_of_side).value());
  scene.bodies.push_back(
      {.name = "die",
       .shape = std::shared_ptr<const Compound>(shape),
       .inertia = {.mass_kg = k_mass_kg,
                   .principal_kgm2 = Vec3::Constant(k_mass_kg * k_side_m * k_side_m / 6),
                   .symmetry = InertiaSymmetry::spherical},
       .start = {}});
  return scene;
}

/// Simulates until rest, for at most 6 s. The same limit holds for other engines.
Pose rest_of(Scene& scene, std::uint64_t number) {
  scene.bodies[0].start = throw_of(number);
  auto started = Simulation::start(scene, {.record = false});
  CHECK(started.ok());
  Simulation simulation = std::move(started).value();
  for (int tenth = 1; tenth <= 60 && simulation.mode({0}) != MotionMode::resting; ++tenth)
    CHECK(!simulation.run_until(Tick{} + ticks_after(0.1 * tenth)));
  return simulation.pose({0}, simulation.now());
}

void rest(benchmark::State& state) {
  constexpr std::uint64_t k_throws = 500;
  Scene scene = table();
  ResultHash hash;
  for (std::uint64_t i = 0; i < 20; ++i) {
    const Pose pose = rest_of(scene, i);
    hash.add(pose.position_m.x());
    hash.add(pose.orientation.w());
  }
  std::uint64_t i = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(rest_of(scene, i++ % k_throws));
  state.SetItemsProcessed(state.iterations());
  verify(state, hash.value(), 0xd15f8cc703400cb7U);
}
BENCHMARK(rest)->Name("die/rest")->Unit(benchmark::kMillisecond)->MinTime(2);

}  // namespace
}  // namespace sleight::bench
