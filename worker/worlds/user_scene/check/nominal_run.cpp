#include "worker/worlds/user_scene/check/nominal_run.h"

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "worker/physics/simulator/simulation.h"
#include "worker/worlds/user_scene/static_owners.h"

namespace sleight::worlds::user_scene {
namespace {

using physics::BodyId;
using physics::MotionMode;
using physics::Tick;

double seconds_at(Tick tick) {
  return physics::seconds(tick - Tick{});
}

std::uint64_t events_of(const physics::Counts& counts) {
  return counts.collisions + counts.static_collisions + counts.modes;
}

class Run {
 public:
  Run(const BuiltScene& built, const physics::Simulation& simulation)
      : built_(built), simulation_(simulation) {
    for (const physics::BodyDescription& body : built.scene.bodies) {
      const Vec3 around_m = Vec3::Constant(physics::reach_m(body.shape));
      surround(body.start.pose.position_m - around_m);
      surround(body.start.pose.position_m + around_m);
    }
    for (const physics::StaticConvex& convex : built.scene.convexes)
      std::ranges::for_each(convex.polyhedron->vertices_m(), [&](const Vec3& p) { surround(p); });
    for (const physics::StaticMesh& mesh : built.scene.meshes)
      std::ranges::for_each(mesh.mesh->vertices_m(), [&](const Vec3& p) { surround(p); });
  }

  bool all_ended() const {
    for (BodyId body{}; body < built_.moving; ++body) {
      if (end_of(body) < BodyEnd::rests) return false;
    }
    return true;
  }

  BodyOutcome outcome(BodyId body) const {
    const Tick now = simulation_.now();
    BodyOutcome result{.end = end_of(body)};
    if (result.end == BodyEnd::waits) return result;
    if (result.end == BodyEnd::rests) {
      const auto segments = simulation_.recording().segments(body);
      auto first = segments.end() - 1;
      while (first != segments.begin() && (first - 1)->segment.mode == MotionMode::resting)
        --first;
      result.rests_since_s = seconds_at(first->segment.flight.begin);
    }
    result.place = composed(simulation_.pose(body, now), inverse(built_.objects[body].frame));
    result.speed_mps = math::norm(simulation_.twist(body, now).velocity_mps);
    return result;
  }

 private:
  BodyEnd end_of(BodyId body) const {
    if (!simulation_.started(body)) return BodyEnd::waits;
    if (simulation_.mode(body) == MotionMode::resting) return BodyEnd::rests;
    return has_left(body) ? BodyEnd::left : BodyEnd::moves;
  }
  bool has_left(BodyId body) const {
    const physics::Scene& scene = built_.scene;
    if (physics::is_zero(scene.gravity_mps2)) return false;
    const Vec3 way = math::normalized(scene.gravity_mps2);
    const double furthest_m =
        math::dot(way.cwiseMax(0.0), high_m_) + math::dot(way.cwiseMin(0.0), low_m_);
    const Vec3 centre_m = simulation_.pose(body, simulation_.now()).position_m;
    return math::dot(way, centre_m) - furthest_m > (high_m_ - low_m_).maxCoeff() &&
           std::ranges::none_of(scene.planes, [&](const physics::StaticPlane& plane) {
             return math::dot(plane.outside.normal, way) < 0 &&
                    scene.filter.meet(plane.group, scene.bodies[body].group);
           });
  }
  void surround(const Vec3& point_m) {
    low_m_ = low_m_.cwiseMin(point_m);
    high_m_ = high_m_.cwiseMax(point_m);
  }

  const BuiltScene& built_;
  const physics::Simulation& simulation_;
  // A box around everything except planes.
  Vec3 low_m_ = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high_m_ = -low_m_;
};

void add_hits(const BuiltScene& built, NominalRun& run) {
  // A collision may begin segments of several bodies, so list each collision once.
  std::set<physics::EventKey> collisions;
  for (std::uint32_t body = 0; body < built.moving; ++body) {
    for (const physics::Recording::Entry& entry : run.recording->segments({body})) {
      if (entry.cause.kind == physics::EventKind::collision) collisions.insert(entry.cause);
    }
  }
  const StaticOwners owners(built);
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> index_of;
  for (const physics::EventKey& event : collisions) {
    const std::uint32_t a = event.lower;
    const std::uint32_t b = event.is_with_static() ? owners.owner(a, event.met()) : event.higher;
    const auto [at, is_first] = index_of.try_emplace({a, b}, run.hits.size());
    if (is_first) run.hits.push_back({.a = a, .b = b, .first_s = seconds_at(event.tick)});
    ++run.hits[at->second].count;
    ++run.bodies[a].hits;
    if (b < built.moving) ++run.bodies[b].hits;
  }
}

}  // namespace

NominalRun nominal_run(const SceneDescription& description, const BuiltScene& built,
                       std::uint64_t events_max) {
  auto started = physics::Simulation::start(built.scene, {});
  if (!started) return {.end = RunEnd::error, .error = started.error()};
  NominalRun result{.end = RunEnd::error};
  physics::Simulation simulation = std::move(started).value();
  const Run run(built, simulation);
  const Tick end = Tick{} + physics::ticks_after(description.end_s);
  while (!result.error && simulation.now() < end && !run.all_ended() &&
         events_of(simulation.counts()) <= events_max)
    result.error =
        simulation.run_until(std::min(end, simulation.now() + physics::ticks_after(1.0 / 256)));
  if (!result.error)
    result.end = run.all_ended()           ? RunEnd::all_ended
                 : simulation.now() == end ? RunEnd::time_over
                                           : RunEnd::work_limit;
  result.end_s = seconds_at(simulation.now());
  for (BodyId body{}; body < built.moving; ++body)
    result.bodies.push_back(run.outcome(body));
  result.recording = std::make_shared<const physics::Recording>(simulation.recording());
  add_hits(built, result);
  return result;
}

}  // namespace sleight::worlds::user_scene
