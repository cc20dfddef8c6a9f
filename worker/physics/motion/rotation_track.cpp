#include "worker/physics/motion/rotation_track.h"

namespace sleight::physics {

Quat orientation_at(const FreeFlight& flight, const Inertia& inertia, Tick t) {
  if (t == flight.begin) return flight.orientation;
  if (inertia.symmetry == InertiaSymmetry::general)
    return GeneralRotation(flight, inertia).orientation_at(t - flight.begin);
  return turned(closed_rotation(flight, inertia), flight.orientation,
                seconds_since_begin(flight, t));
}

Vec3 angular_velocity_at(const FreeFlight& flight, const Inertia& inertia, Tick t) {
  if (t == flight.begin) return flight.angular_velocity_radps;
  if (inertia.symmetry == InertiaSymmetry::general)
    return GeneralRotation(flight, inertia).angular_velocity_at(t - flight.begin);
  return precessed(closed_rotation(flight, inertia), flight.angular_velocity_radps,
                   seconds_since_begin(flight, t));
}

Tick rotation_horizon(const FreeFlight& flight, const Inertia& inertia) {
  return RotationTrack(flight, inertia).horizon();
}

void RotationTrack::restart(const FreeFlight& flight, const Inertia& inertia) {
  begin_ = flight.begin;
  orientation_ = flight.orientation;
  angular_velocity_radps_ = flight.angular_velocity_radps;
  is_general_ = inertia.symmetry == InertiaSymmetry::general;
  if (!is_general_) {
    closed_ = closed_rotation(flight, inertia);
  } else if (general_) {
    *general_ = GeneralRotation(flight, inertia);
  } else {
    general_ = std::make_unique<GeneralRotation>(flight, inertia);
  }
}

Tick RotationTrack::horizon() const {
  if (!is_general_) return k_tick_max;
  const TickCount span = general_->span_max();
  return k_tick_max - begin_ < span ? k_tick_max : begin_ + span;
}

Quat RotationTrack::orientation_at(Tick t) {
  if (t == begin_) return orientation_;
  if (is_general_) return general_->orientation_at(t - begin_);
  return turned(closed_, orientation_, seconds(t - begin_));
}

Vec3 RotationTrack::angular_velocity_at(Tick t) {
  if (t == begin_) return angular_velocity_radps_;
  if (is_general_) return general_->angular_velocity_at(t - begin_);
  return precessed(closed_, angular_velocity_radps_, seconds(t - begin_));
}

}  // namespace sleight::physics
