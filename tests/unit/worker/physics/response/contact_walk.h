// Follows a motion in lasting contact from segment to segment.
//
// Thread safety: values and pure functions.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "common/math/vector.h"
#include "worker/physics/event/tick.h"
#include "worker/physics/response/contact_motion.h"

namespace sleight::physics::response_reference {

inline constexpr double k_g = 9.81;
inline constexpr double k_pi = 3.14159265358979323846;

struct Trial {
  std::string name{};
  RoundBody body{.radius_m = 0.01};
  std::vector<LastingContact> contacts{};
  Twist twist{};
  Vec3 gravity_mps2 = Vec3(0, 0, -k_g);
  double until_s = 1;
};

inline Trial turned(const Quat& by, Trial trial) {
  for (LastingContact& contact : trial.contacts)
    contact.normal = math::normalized(math::rotated(by, contact.normal));
  trial.twist = {math::rotated(by, trial.twist.velocity_mps),
                 math::rotated(by, trial.twist.angular_velocity_radps)};
  trial.gravity_mps2 = math::rotated(by, trial.gravity_mps2);
  return trial;
}

/// Gravity on a slope that descends along x. In the frame used, the slope is the plane z = 0.
inline Vec3 gravity_on_slope(double slope_rad) {
  return {k_g * std::sin(slope_rad), 0, -k_g * std::cos(slope_rad)};
}

/// Two planes that meet in a line along x. Each plane has its own angle from z = 0.
inline std::vector<LastingContact> valley(double angle_a, double angle_b, double mu_a, double mu_b,
                                          double c_a = 0, double c_b = 0) {
  return {
      {.normal = Vec3(0, std::sin(angle_a), std::cos(angle_a)),
       .friction = mu_a,
       .rolling_friction = c_a},
      {.normal = Vec3(0, -std::sin(angle_b), std::cos(angle_b)),
       .friction = mu_b,
       .rolling_friction = c_b},
  };
}

/// Follows a motion. As in the simulator, a segment lasts until the first whole tick after its end.
class Walk {
 public:
  explicit Walk(const Trial& trial) : trial_(trial), twist_(trial.twist) { begin(); }

  /// REQUIRES: `time_s` doesn't decrease from call to call.
  void go_to(double time_s) {
    while (holds() && begin_s_ + lasts_s_ <= time_s)
      next();
    const double s = time_s - begin_s_;
    twist_ = twist_after(s);
    way_m_ = begin_way_m_ + way_after(s);
  }

  /// Moves to the next segment. REQUIRES: the current segment ends.
  void next() {
    begin_way_m_ += way_after(lasts_s_);
    twist_ = twist_after(lasts_s_);
    begin_s_ += lasts_s_;
    begin();
  }

  const ContactMotion& motion() const { return motion_; }
  const Twist& twist() const { return twist_; }
  const Vec3& way_m() const { return way_m_; }
  double begin_s() const { return begin_s_; }
  double lasts_s() const { return lasts_s_; }
  int segments() const { return segments_; }
  /// Returns whether the ball presses on all faces.
  bool holds() const { return motion_.pressed == (1U << trial_.contacts.size()) - 1; }
  bool is_last() const { return !holds() || std::isinf(lasts_s_); }

  Twist twist_after(double s) const {
    return {motion_.start.velocity_mps + s * motion_.acceleration_mps2,
            motion_.start.angular_velocity_radps + s * motion_.angular_acceleration_radps2};
  }

 private:
  void begin() {
    motion_ = contact_motion(trial_.body, trial_.contacts, twist_, trial_.gravity_mps2);
    lasts_s_ = std::isinf(motion_.lasts_s)
                   ? motion_.lasts_s
                   : seconds(std::max<TickCount>(1, ticks_after(motion_.lasts_s)));
    ++segments_;
  }
  Vec3 way_after(double s) const {
    return s * motion_.start.velocity_mps + (0.5 * s * s) * motion_.acceleration_mps2;
  }

  const Trial& trial_;
  ContactMotion motion_;
  Twist twist_;
  Vec3 way_m_ = Vec3::Zero();
  Vec3 begin_way_m_ = Vec3::Zero();
  double begin_s_ = 0;
  double lasts_s_ = 0;
  int segments_ = 0;
};

}  // namespace sleight::physics::response_reference
