#include "worker/worlds/segments/segment_values.h"

namespace sleight::worlds {

void append_segment(const physics::Segment& segment, const math::Quat& orientation,
                    std::vector<double>& values) {
  const physics::FreeFlight& flight = segment.flight;
  values.insert(values.end(), {physics::seconds(flight.begin - physics::Tick{}),
                               static_cast<double>(segment.mode)});
  append_vector(flight.position_m, values);
  append_vector(flight.velocity_mps, values);
  append_vector(flight.acceleration_mps2, values);
  append_quaternion(orientation, values);
  append_vector(flight.angular_velocity_radps, values);
}

}  // namespace sleight::worlds
