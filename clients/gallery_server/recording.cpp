#include "clients/gallery_server/recording.h"

#include <vector>

#include "clients/gallery_server/meshes.h"
#include "common/json/value.h"

namespace sleight::gallery {

void add_motion(Packed& to, const std::string& prefix, const motion::Animation& motion) {
  std::vector<std::uint32_t> body;
  std::vector<double> start_s;
  std::vector<std::uint8_t> mode;
  std::vector<std::uint8_t> cause;
  std::vector<std::int32_t> partner;
  std::vector<double> position_m;
  std::vector<double> velocity_mps;
  std::vector<double> acceleration_mps2;
  std::vector<double> orientation;
  std::vector<double> angular_velocity_radps;
  std::vector<double> angular_acceleration_radps2;
  for (const motion::Path& path : motion.paths()) {
    for (const motion::Segment& segment : path.segments()) {
      body.push_back(segment.body);
      start_s.push_back(segment.start_s);
      mode.push_back(static_cast<std::uint8_t>(segment.mode));
      cause.push_back(static_cast<std::uint8_t>(segment.cause));
      partner.push_back(segment.partner);
      append(position_m, segment.position_m);
      append(velocity_mps, segment.velocity_mps);
      append(acceleration_mps2, segment.acceleration_mps2);
      const math::Quat& q = segment.orientation;
      orientation.insert(orientation.end(), {q.w(), q.x(), q.y(), q.z()});
      append(angular_velocity_radps, segment.angular_velocity_radps);
      append(angular_acceleration_radps2, segment.angular_acceleration_radps2);
    }
  }
  to.add(prefix + "body", body);
  to.add(prefix + "start_s", start_s);
  to.add(prefix + "mode", mode);
  to.add(prefix + "cause", cause);
  to.add(prefix + "partner", partner);
  to.add(prefix + "position_m", position_m);
  to.add(prefix + "velocity_mps", velocity_mps);
  to.add(prefix + "acceleration_mps2", acceleration_mps2);
  to.add(prefix + "orientation", orientation);
  to.add(prefix + "angular_velocity_radps", angular_velocity_radps);
  to.add(prefix + "angular_acceleration_radps2", angular_acceleration_radps2);
}

json::Value add_animation(Packed& to, const std::string& prefix, const std::string& name,
                          const browse::KeptAnimation& animation, const scene::Scene& scene) {
  add_motion(to, prefix, animation.motion);
  json::Value meshes = add_meshes(to, prefix, scene, own_features(scene, animation.own),
                                  animation.own, animation.offsets_m);
  return {{"name", name},
          {"end_s", animation.motion.end_s()},
          {"columns", prefix},
          {"meshes", std::move(meshes)}};
}

}  // namespace sleight::gallery
