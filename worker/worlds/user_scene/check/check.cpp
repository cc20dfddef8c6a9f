#include "worker/worlds/user_scene/check/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "worker/physics/scene/static_regions.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::worlds::user_scene {
namespace {

constexpr double k_infinity = std::numeric_limits<double>::infinity();
/// With fewer draws, a constraint that none comes near isn't surprising.
constexpr std::uint64_t k_draws_min = 50;
/// A distance of more than this many sigmas is far.
constexpr double k_far = 3;
/// If the masses of two bodies that meet differ by more than this factor, a warning says so.
constexpr double k_mass_ratio_max = 1e3;

std::vector<Closedness> closedness_of(const BuiltScene& built) {
  std::vector<Closedness> all;
  for (std::uint32_t object = built.bodies; object < built.objects.size(); ++object) {
    if (built.objects[object].kind != ObjectKind::mesh) continue;
    const physics::TriangleMesh& mesh = *built.scene.meshes[built.objects[object].first].mesh;
    Closedness one{.object = object};
    for (const physics::MeshEdge& edge : mesh.edges())
      one.boundary_edges += edge.kind == physics::EdgeKind::boundary ? 1 : 0;
    if (one.boundary_edges == 0) one.volume_m3 = physics::enclosed_m3(mesh);
    all.push_back(one);
  }
  return all;
}

std::string describe(const Overlap& one, const std::string& a, const std::string& b) {
  if (one.inside) return fmt::format("'{}' is inside '{}' at the start.", a, b);
  if (one.depth_m <= physics::k_touch_m)
    return fmt::format("'{}' touches '{}' at the start. Leave a gap, or set rests = true.", a, b);
  return fmt::format("'{}' overlaps '{}' by {:.3g} mm at the start.", a, b, 1e3 * one.depth_m);
}

std::vector<std::string> warnings_of(const SceneReport& report) {
  const BuiltScene& built = report.built;
  const auto name = [&](std::uint32_t object) { return built.objects[object].name; };
  std::vector<std::string> all;
  for (const Closedness& mesh : report.meshes) {
    if (mesh.volume_m3 < 0)
      all.push_back(fmt::format(
          "Mesh '{}' is inside out: everything outside it is solid. Reverse its triangles.",
          name(mesh.object)));
  }
  for (const Overlap& one : report.overlaps)
    all.push_back(describe(one, name(one.a), name(one.b)));
  if (!report.run) return all;
  const NominalRun& run = *report.run;
  if (run.error)
    all.push_back(
        fmt::format("The simulation failed at {:.6g} s: {}.", run.end_s, run.error->message));
  if (run.end == RunEnd::work_limit)
    all.push_back(
        fmt::format("The check stopped its simulation at {:.6g} s, after {} events. Directing "
                    "such a scene takes long.",
                    run.end_s, k_run_events_max));
  for (std::uint32_t body = 0; body < run.bodies.size(); ++body) {
    if (run.bodies[body].end == BodyEnd::left)
      all.push_back(fmt::format("'{}' falls out of the scene.", name(body)));
  }
  for (const Hits& hits : run.hits) {
    if (hits.b >= built.moving) continue;
    const double ratio = built.inertia(hits.a).mass_kg / built.inertia(hits.b).mass_kg;
    if (std::max(ratio, 1 / ratio) > k_mass_ratio_max)
      all.push_back(
          fmt::format("'{}' and '{}' meet, and one is {:.3g} times heavier: contacts may be "
                      "inaccurate, or fail.",
                      name(hits.a), name(hits.b), std::max(ratio, 1 / ratio)));
  }
  return all;
}

std::vector<std::string> warnings_of(const UserScene& world, const PriorDraws& draws) {
  std::vector<std::string> all;
  const auto share = [&](std::uint64_t count, const char* what) {
    if (count > 0)
      all.push_back(fmt::format("In {} of {} prior draws, {}.", count, draws.count, what));
  };
  share(draws.overlap,
        "bodies overlap where one starts, one can't rest there, or a box is too flat; such draws "
        "have p_c = 0");
  share(draws.failed, "the simulator fails; such draws are never samples");
  share(draws.not_settled, "a body still moves at end_s, so it isn't at rest");
  for (std::size_t i = 0; draws.count >= k_draws_min && i < draws.least_distances.size(); ++i) {
    const Constraint& one = world.parameters().constraints[i];
    const double distance = draws.least_distances[i];
    if (!std::isfinite(distance) || distance <= std::max(one.tolerance, k_far * one.sigma))
      continue;
    all.push_back(fmt::format(
        "None of {} prior draws comes near constraint '{}': the least distance is {:.4g} {}.",
        draws.count, one.name, distance / unit_of(one).scale, unit_of(one).name));
  }
  return all;
}

}  // namespace

SceneReport check(const SceneDescription& description, const BuiltScene& built) {
  SceneReport report{.description = description, .built = built, .meshes = closedness_of(built)};
  // Overlaps are defined only for valid scenes. The simulator refuses other scenes.
  if (!physics::error_of(built.scene)) report.overlaps = overlaps_of(built);
  if (report.overlaps.empty()) report.run = nominal_run(description, built);
  report.warnings = warnings_of(report);
  return report;
}

PriorDraws prior_draws(const UserScene& world, std::uint64_t count_max,
                       const std::function<bool(std::uint64_t done)>& go_on) {
  const std::vector<Constraint>& constraints = world.parameters().constraints;
  PriorDraws draws{.constraint_met = std::vector<std::uint64_t>(constraints.size(), 0),
                   .least_distances = std::vector<double>(constraints.size(), k_infinity)};
  while (draws.count < count_max && (draws.count == 0 || go_on(draws.count))) {
    const State state = sampling::nth_prior_draw(world, draws.count++);
    const std::vector<double> values = world.quantities().values(state.numbers);
    draws.values.resize(values.size(), {k_infinity, 0, -k_infinity});
    for (std::size_t i = 0; i < values.size(); ++i) {
      auto& [least, mean, greatest] = draws.values[i];
      least = std::min(least, values[i]);
      mean += (values[i] - mean) / static_cast<double>(draws.count);
      greatest = std::max(greatest, values[i]);
    }
    const Outcome outcome = world.simulate(state);
    draws.overlap += outcome.end == End::impossible ? 1 : 0;
    draws.failed += outcome.end == End::failed ? 1 : 0;
    draws.not_settled += outcome.end == End::time_limit ? 1 : 0;
    draws.met += world.satisfied(outcome) ? 1 : 0;
    for (std::size_t i = 0; i < outcome.judgement.distances.size(); ++i) {
      const double distance = outcome.judgement.distances[i];
      draws.constraint_met[i] += outcome.judgement.met[i] ? 1 : 0;
      draws.least_distances[i] = std::min(draws.least_distances[i], distance);
    }
  }
  return draws;
}

void add_draws(const UserScene& world, PriorDraws draws, SceneReport& report) {
  for (std::string& warning : warnings_of(world, draws))
    report.warnings.push_back(std::move(warning));
  report.draws = std::move(draws);
  report.world = &world;
}

}  // namespace sleight::worlds::user_scene
