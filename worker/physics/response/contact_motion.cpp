#include "worker/physics/response/contact_motion.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/check.h"
#include "common/math/vector.h"
#include "worker/physics/response/held_slip.h"
#include "worker/physics/response/linear_system.h"
#include "worker/physics/response/valley_motion.h"

namespace sleight::physics {
namespace {

using math::cross;
using math::dot;
using math::norm;

// ---- one face -----------------------------------------------------------------------------------

/// Brakes the sphere's spin about the face's normal.
void brake_pivot(const RoundBody& body, const LastingContact& contact, double load_mps2,
                 ContactMotion& motion) {
  if (contact.rolling_friction == 0) return;
  Vec3& spin = motion.start.angular_velocity_radps;
  const double pivot_radps = dot(spin, contact.normal);
  if (std::fabs(pivot_radps) * body.radius_m < k_stick_mps) {
    spin -= pivot_radps * contact.normal;
    return;
  }
  const double rate = contact.rolling_friction * load_mps2 / (body.gyration * body.radius_m);
  motion.angular_acceleration_radps2 -= std::copysign(rate, pivot_radps) * contact.normal;
  motion.lasts_s = std::min(motion.lasts_s, std::fabs(pivot_radps) / rate);
}

/// Sets the motion of a sphere while friction acts in one direction.
void slide(const RoundBody& body, const LastingContact& contact, const Vec3& pull_mps2,
           double load_mps2, const HeldSlip& slip, ContactMotion& motion) {
  const Vec3 direction = slip.direction - dot(slip.direction, contact.normal) * contact.normal;
  const Vec3 friction = -(contact.friction * load_mps2) * direction;
  motion.acceleration_mps2 = pull_mps2 + friction;
  motion.angular_acceleration_radps2 =
      -cross(contact.normal, friction) / (body.gyration * body.radius_m);
  motion.lasts_s = slip.lasts_s;
}

/// Limits the rolling resistance to what friction can transmit. If the resistance acts against a
/// direction d, its limit x satisfies |turning - x d| = mu N.
struct PassedOn {
  Vec3 turning;       ///< the friction that turns the sphere, without resistance
  double spare;       ///< (mu N)^2 - turning^2
  double resistance;  ///< to rolling
  double against(const Vec3& direction) const {
    const double along = dot(turning, direction);
    return std::min(resistance, along + std::sqrt(along * along + spare));
  }
};

struct Rolling {
  Vec3 acceleration_mps2;
  double lasts_s = k_forever_s;
};
/// Subtracts rolling resistance from the acceleration `a`; returns the result and how long it is
/// valid. Stops a slow sphere first.
Rolling resisted(const RoundBody& body, const Vec3& n, Vec3 a, const PassedOn& most, Twist& start) {
  Vec3& v = start.velocity_mps;
  const double pull = norm(a);
  const bool still = norm(v) <= k_stick_mps;
  if (still) {
    // When the centre stops, so does the part of the spin that rolls the sphere.
    start.angular_velocity_radps -= cross(n, v) / body.radius_m;
    v = Vec3::Zero();
    const double held = pull > 0 ? most.against(a / pull) : 0;
    a *= pull > held ? (pull - held) / pull : 0;
    return {a};
  }
  const Vec3 now = math::normalized(v);
  const HeldSlip along = held_slip(v, a, most.against(now), body.slip_error_mps());
  a -= most.against(along.direction) * along.direction;
  return {a, std::min(along.lasts_s, stop_s(v, a, along.direction))};
}

ContactMotion on_a_face(const RoundBody& body, const LastingContact& contact, const Twist& twist,
                        const Vec3& gravity_mps2) {
  ContactMotion motion{.pressed = 0, .start = twist};
  const Vec3& n = contact.normal;
  const double load_mps2 = -dot(gravity_mps2, n);
  if (!(load_mps2 > 0)) return motion;
  motion.pressed = 1;
  const Vec3 pull_mps2 = gravity_mps2 + load_mps2 * n;
  Vec3& v = motion.start.velocity_mps;
  const Vec3& w = motion.start.angular_velocity_radps;
  v -= dot(v, n) * n;
  const double k = body.gyration;
  const double mobility = 1 + 1 / k;  // of the contact point; the centre's is 1
  const Vec3 slip = v - body.radius_m * cross(w, n);
  if (contact.friction == 0) {
    motion.acceleration_mps2 = pull_mps2;
    brake_pivot(body, contact, load_mps2, motion);
    return motion;
  }
  const double brake = contact.friction * load_mps2 * mobility;
  if (norm(slip) > body.stick_mps) {
    HeldSlip along = held_slip(slip, pull_mps2, brake, body.slip_error_mps());
    along.lasts_s =
        std::min(along.lasts_s, stop_s(slip, pull_mps2 - brake * along.direction, along.direction));
    slide(body, contact, pull_mps2, load_mps2, along, motion);
    brake_pivot(body, contact, load_mps2, motion);
    return motion;
  }

  // The sphere rolls if friction can turn it fast enough.
  stop_slip(body, n, motion.start);
  const double resistance = contact.rolling_friction * load_mps2;
  Rolling rolling{pull_mps2 / (1 + k)};
  const Vec3 turning = rolling.acceleration_mps2 - pull_mps2;
  const double spare =
      contact.friction * load_mps2 * contact.friction * load_mps2 - dot(turning, turning);
  if (spare < 0) {
    slide(body, contact, pull_mps2, load_mps2, {-math::normalized(turning), k_forever_s}, motion);
    brake_pivot(body, contact, load_mps2, motion);
    return motion;
  }
  if (resistance > 0) {
    rolling =
        resisted(body, n, rolling.acceleration_mps2, {turning, spare, resistance}, motion.start);
  }
  motion.rolls = true;
  motion.acceleration_mps2 = rolling.acceleration_mps2;
  motion.angular_acceleration_radps2 = cross(n, rolling.acceleration_mps2) / body.radius_m;
  motion.lasts_s = rolling.lasts_s;
  brake_pivot(body, contact, load_mps2, motion);
  return motion;
}

// ---- three faces --------------------------------------------------------------------------------

ContactMotion in_a_corner(const RoundBody& body, std::span<const LastingContact> contacts,
                          const Twist& twist, const Vec3& gravity_mps2) {
  ContactMotion motion{.pressed = 0, .start = {.velocity_mps = Vec3::Zero()}};
  Vec3& w = motion.start.angular_velocity_radps;
  w = twist.angular_velocity_radps;
  if (norm(w) * body.radius_m < k_stick_mps) w = Vec3::Zero();
  // Friction against the spin changes the faces' loads.
  std::array<double, 3> slips_mps{};
  LinearSystem loads_of(3);
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 slip = -body.radius_m * cross(w, contacts[i].normal);
    slips_mps[i] = norm(slip);
    Vec3 push = contacts[i].normal;
    if (slips_mps[i] > 0) push -= (contacts[i].friction / slips_mps[i]) * slip;
    for (std::size_t row = 0; row < 3; ++row)
      loads_of.coefficient(row, i) = push[static_cast<int>(row)];
  }
  for (std::size_t row = 0; row < 3; ++row)
    loads_of.right(row) = -gravity_mps2[static_cast<int>(row)];
  std::array<double, LinearSystem::k_most> loads{};
  if (!loads_of.solve(loads)) return motion;
  double power = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    motion.pressed |= (loads[i] > 0 ? 1U : 0U) << i;
    power += contacts[i].friction * loads[i] * slips_mps[i];
  }
  motion.rolls = !(power > 0);
  if (motion.rolls || motion.pressed != 7) return motion;
  const double speed = norm(w);
  const double brake = power / (body.gyration * body.radius_m * body.radius_m * speed);
  motion.angular_acceleration_radps2 = -(brake / speed) * w;
  motion.lasts_s = speed / brake;
  return motion;
}

}  // namespace

Vec3 along_faces(std::span<const LastingContact> contacts, const Vec3& velocity_mps) {
  if (contacts.size() > 2) return Vec3::Zero();
  const Vec3& n = contacts[0].normal;
  if (contacts.size() == 1) return velocity_mps - dot(velocity_mps, n) * n;
  const Vec3 line = math::normalized(cross(n, contacts[1].normal));
  return dot(velocity_mps, line) * line;
}

void stop_slip(const RoundBody& body, const Vec3& normal, Twist& twist) {
  Vec3& v = twist.velocity_mps;
  Vec3& w = twist.angular_velocity_radps;
  const double k = body.gyration;
  const Vec3 slip = v - body.radius_m * cross(w, normal);
  const Vec3 impulse = -slip / (1 + 1 / k);
  v += impulse;
  w -= cross(normal, impulse) / (k * body.radius_m);
}

Twist hop(const RoundBody& body, const Vec3& normal, const Twist& twist, double speed_mps) {
  const double rising_mps = std::max(0.0, dot(twist.velocity_mps, normal));
  if (rising_mps >= speed_mps) return twist;
  const Vec3 along_mps = twist.velocity_mps - dot(twist.velocity_mps, normal) * normal;
  const Vec3 turning_mps = body.radius_m * twist.angular_velocity_radps;
  const double purse = dot(along_mps, along_mps) + body.gyration * dot(turning_mps, turning_mps);
  if (!(purse > 0)) return twist;
  const double price = std::min(speed_mps * speed_mps - rising_mps * rising_mps, 0.5 * purse);
  const double share = std::sqrt(1 - price / purse);
  return {.velocity_mps = share * along_mps + std::sqrt(rising_mps * rising_mps + price) * normal,
          .angular_velocity_radps = share * twist.angular_velocity_radps};
}

bool is_valley(const Vec3& normal_a, const Vec3& normal_b) {
  return dot(normal_a, normal_b) > k_valley_cosine_min &&
         norm(cross(normal_a, normal_b)) > k_valley_sine_min;
}

ContactMotion contact_motion(const RoundBody& body, std::span<const LastingContact> contacts,
                             const Twist& twist, const Vec3& gravity_mps2) {
  CHECK(contacts.size() >= 1 && contacts.size() <= 3);
  if (contacts.size() == 1) return on_a_face(body, contacts[0], twist, gravity_mps2);
  if (contacts.size() == 3) return in_a_corner(body, contacts, twist, gravity_mps2);
  return valley_motion(body, contacts, twist, gravity_mps2);
}

}  // namespace sleight::physics
