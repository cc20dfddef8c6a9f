#include "worker/worlds/user_scene/end_watch.h"

#include <algorithm>

namespace sleight::worlds::user_scene {

using physics::BodyId;

bool all_ended(const BuiltScene& built, const physics::Scene& scene,
               const physics::Simulation& simulation) {
  for (BodyId body{}; body < built.moving; ++body) {
    if (scene.bodies[body].start_tick != physics::k_tick_max &&
        end_of(built, simulation, body) < BodyEnd::rests)
      return false;
  }
  return true;
}

BodyEnd end_of(const BuiltScene& built, const physics::Simulation& simulation, BodyId body) {
  if (!simulation.started(body)) return BodyEnd::waits;
  if (simulation.mode(body) == physics::MotionMode::resting) return BodyEnd::rests;
  const physics::Scene& scene = built.scene;
  if (physics::is_zero(scene.gravity_mps2)) return BodyEnd::moves;
  const Vec3 way = math::normalized(scene.gravity_mps2);
  const double furthest_m =
      math::dot(way.cwiseMax(0.0), built.high_m) + math::dot(way.cwiseMin(0.0), built.low_m);
  const Vec3 centre_m = simulation.pose(body, simulation.now()).position_m;
  const bool has_left =
      math::dot(way, centre_m) - furthest_m > (built.high_m - built.low_m).maxCoeff() &&
      std::ranges::none_of(scene.planes, [&](const physics::StaticPlane& plane) {
        return math::dot(plane.outside.normal, way) < 0 &&
               scene.filter.meet(plane.group, scene.bodies[body].group);
      });
  return has_left ? BodyEnd::left : BodyEnd::moves;
}

}  // namespace sleight::worlds::user_scene
