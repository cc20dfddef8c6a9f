#include "worker/physics/response/valley_motion.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/math/vector.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/response/held_slip.h"
#include "worker/physics/response/linear_system.h"

namespace sleight::physics {
namespace {

using math::cross;
using math::dot;
using math::norm;

/// Returns the acceleration of a sphere that rolls along a line: `pull`, reduced by a resistance of
/// at most `most`. A resting sphere stays at rest if the resistance can hold it.
double resisted(double velocity, double pull, double most) {
  if (velocity == 0) return std::fabs(pull) <= most ? 0 : pull - std::copysign(most, pull);
  return pull - std::copysign(most, velocity);
}

/// A sphere in a valley. Accelerations and forces are per mass.
class Valley {
 public:
  Valley(const RoundBody& body, std::span<const LastingContact> contacts, const Twist& twist,
         const Vec3& gravity_mps2)
      : body_(body),
        contacts_{contacts[0], contacts[1]},
        gravity_(gravity_mps2),
        cosine_(dot(contacts[0].normal, contacts[1].normal)),
        line_(math::normalized(cross(contacts[0].normal, contacts[1].normal))) {
    for (std::size_t i = 0; i < 2; ++i)
      side_[i] = cross(contacts_[i].normal, line_);
    motion_.start = {.velocity_mps = along_faces(contacts, twist.velocity_mps),
                     .angular_velocity_radps = twist.angular_velocity_radps};
  }

  ContactMotion motion() {
    for (std::size_t i = 0; i < 2; ++i) {
      const Vec3 slip = slip_at(i);
      slips_[i] = norm(slip) > body_.stick_mps || contacts_[i].friction == 0;
      direction_[i] =
          slips_[i] && norm(slip) > 0 ? Vec3(math::normalized(slip)) : Vec3(Vec3::Zero());
    }
    if (!slips_[0] && !slips_[1]) {
      if (rolls()) return motion_;
    } else if (slips_[0] != slips_[1]) {
      stop_slip(slips_[0] ? 1 : 0);
    }
    if (!forces()) return motion_;
    for (std::size_t i = 0; i < 2; ++i)
      let_slip(i);
    if (motion_.pressed != 3) return motion_;
    hold_directions();
    return motion_;
  }

 private:
  /// Returns the velocity of the sphere's surface at a contact.
  Vec3 slip_at(std::size_t i) const {
    return motion_.start.velocity_mps -
           body_.radius_m * cross(motion_.start.angular_velocity_radps, contacts_[i].normal);
  }

  /// Tries a motion without slip: the sphere rolls along the line. Returns false if friction
  /// doesn't suffice.
  bool rolls() {
    const double k = body_.gyration;
    const double r = body_.radius_m;
    // The loads balance the pull across the valley, so no friction is needed in this direction.
    const double in_a = dot(gravity_, contacts_[0].normal);
    const double in_b = dot(gravity_, contacts_[1].normal);
    const double sine2 = 1 - cosine_ * cosine_;
    const std::array<double, 2> loads{-(in_a - cosine_ * in_b) / sine2,
                                      -(in_b - cosine_ * in_a) / sine2};
    set_pressed(loads);
    if (motion_.pressed != 3) return true;

    const Vec3 spin_per_mps = (side_[0] + side_[1]) / (r * (1 + cosine_));
    const double inertia = k * r * r * dot(spin_per_mps, spin_per_mps);
    // Choose the rolling motion whose difference from the present motion has the least kinetic
    // energy.
    double speed = (dot(motion_.start.velocity_mps, line_) +
                    k * r * r * dot(motion_.start.angular_velocity_radps, spin_per_mps)) /
                   (1 + inertia);
    double resistance = 0;
    for (std::size_t i = 0; i < 2; ++i) {
      resistance +=
          std::min(contacts_[i].rolling_friction, contacts_[i].friction) * std::fabs(loads[i]);
    }
    resistance *= (1 + k) * r * norm(spin_per_mps) / (1 + inertia);
    const double pull = dot(gravity_, line_);
    if (resistance > 0 && std::fabs(speed) <= k_stick_mps) speed = 0;
    const double free_a = pull / (1 + inertia);
    double a = resisted(speed, free_a, resistance);
    // Limit resistance to what the contacts can transmit, because resistance must not make them
    // slip.
    const double most =
        2 * std::min(contacts_[0].friction * loads[0], contacts_[1].friction * loads[1]);
    if (std::fabs(free_a - pull) <= most) a = std::clamp(a, pull - most, pull + most);
    // Give both contacts the same share of friction, so that the sphere keeps rolling.
    const double friction = 0.5 * (a - pull);
    for (std::size_t i = 0; i < 2; ++i) {
      if (std::fabs(friction) <= contacts_[i].friction * loads[i] * (1 + k_load_rounding)) continue;
      slips_[i] = true;
      direction_[i] = -std::copysign(1.0, friction) * line_;
      begins_[i] = true;
    }
    motion_.start = {.velocity_mps = speed * line_, .angular_velocity_radps = speed * spin_per_mps};
    if (slips_[0] || slips_[1]) return false;
    motion_.rolls = true;
    motion_.acceleration_mps2 = a * line_;
    motion_.angular_acceleration_radps2 = a * spin_per_mps;
    if (resistance > 0 && speed * a < 0) motion_.lasts_s = speed / -a;
    return true;
  }

  /// Removes the slip at one contact by the change of motion that has the least kinetic energy.
  void stop_slip(std::size_t i) {
    const double r = body_.radius_m;
    Vec3& w = motion_.start.angular_velocity_radps;
    const double along = dot(motion_.start.velocity_mps, line_);
    const double turning = dot(w, side_[i]);
    const double speed = (along + body_.gyration * r * turning) / (1 + body_.gyration);
    motion_.start.velocity_mps = speed * line_;
    w += (speed / r - turning) * side_[i] - dot(w, line_) * line_;
  }

  /// An unknown force of size 1: its effect on the centre, and its part in the friction at both
  /// contacts.
  struct Unit {
    Vec3 force;
    std::array<Vec3, 2> friction;
  };
  /// The unknown forces: the two loads and, if one contact sticks, friction at this contact, along
  /// the line and across the valley.
  struct Units {
    std::array<Unit, LinearSystem::k_most> unit;
    std::size_t count = 2;
    bool one_sticks = false;
    std::size_t stuck = 0;  ///< the sticking contact
  };
  Units units() const {
    Units all{.unit = {}, .one_sticks = !slips_[0] || !slips_[1], .stuck = slips_[0] ? 1U : 0U};
    for (std::size_t i = 0; i < 2; ++i) {
      all.unit[i] = {contacts_[i].normal, {Vec3::Zero(), Vec3::Zero()}};
      if (!slips_[i]) continue;
      all.unit[i].friction[i] = -contacts_[i].friction * direction_[i];
      all.unit[i].force += all.unit[i].friction[i];
    }
    if (!all.one_sticks) return all;
    for (const Vec3& way : {line_, side_[all.stuck]}) {
      all.unit[all.count] = {way, {Vec3::Zero(), Vec3::Zero()}};
      all.unit[all.count++].friction[all.stuck] = way;
    }
    return all;
  }
  /// Returns the acceleration that a unit gives to the sphere's surface at a contact: force minus r
  /// (angular acceleration x normal).
  Vec3 surface_acceleration(const Unit& unit, std::size_t at) const {
    Vec3 sum = unit.force;
    for (std::size_t i = 0; i < 2; ++i) {
      sum += cross(cross(contacts_[i].normal, unit.friction[i]), contacts_[at].normal) /
             body_.gyration;
    }
    return sum;
  }
  /// Returns equations that say: the centre doesn't accelerate along the faces' normals, and the
  /// sphere's surface doesn't accelerate at a sticking contact.
  LinearSystem balance(const Units& all) const {
    LinearSystem system(all.count);
    for (std::size_t column = 0; column < all.count; ++column) {
      for (std::size_t i = 0; i < 2; ++i)
        system.coefficient(i, column) = dot(all.unit[column].force, contacts_[i].normal);
      if (!all.one_sticks) continue;
      const Vec3 at_stuck = surface_acceleration(all.unit[column], all.stuck);
      system.coefficient(2, column) = dot(at_stuck, line_);
      system.coefficient(3, column) = dot(at_stuck, side_[all.stuck]);
    }
    for (std::size_t i = 0; i < 2; ++i)
      system.right(i) = -dot(gravity_, contacts_[i].normal);
    if (all.one_sticks) {
      system.right(2) = -dot(gravity_, line_);
      system.right(3) = -dot(gravity_, side_[all.stuck]);
    }
    return system;
  }

  /// Computes loads, friction and accelerations for the present slips. If the sphere doesn't stay
  /// on both faces, sets `pressed` and returns false.
  bool forces() {
    const Units all = units();
    LinearSystem system = balance(all);
    std::array<double, LinearSystem::k_most> sizes{};
    motion_.pressed = 0;
    if (!system.solve(sizes)) return false;
    loads_ = {sizes[0], sizes[1]};
    set_pressed(loads_);
    if (motion_.pressed != 3) return false;

    motion_.acceleration_mps2 = gravity_;
    motion_.angular_acceleration_radps2 = Vec3::Zero();
    friction_ = {Vec3::Zero(), Vec3::Zero()};
    for (std::size_t column = 0; column < all.count; ++column) {
      motion_.acceleration_mps2 += sizes[column] * all.unit[column].force;
      for (std::size_t i = 0; i < 2; ++i)
        friction_[i] += sizes[column] * all.unit[column].friction[i];
    }
    for (std::size_t i = 0; i < 2; ++i) {
      motion_.angular_acceleration_radps2 -=
          cross(contacts_[i].normal, friction_[i]) / (body_.gyration * body_.radius_m);
    }
    return true;
  }

  /// If a sticking contact needs more friction than mu times its load, lets it slip, unless it
  /// would stick again at once.
  void let_slip(std::size_t i) {
    if (slips_[i] || motion_.pressed != 3) return;
    if (norm(friction_[i]) <= contacts_[i].friction * loads_[i]) return;
    slips_[i] = true;
    direction_[i] = -math::normalized(friction_[i]);
    if (forces() && dot(slip_rate(i), direction_[i]) > 0) {
      begins_[i] = true;
      return;
    }
    slips_[i] = false;
    forces();
  }

  /// Returns the acceleration of a contact's surface.
  Vec3 slip_rate(std::size_t i) const {
    return motion_.acceleration_mps2 -
           body_.radius_m * cross(motion_.angular_acceleration_radps2, contacts_[i].normal);
  }

  /// Finds the direction of a beginning slip, which must grow although friction acts against it.
  bool settle_begin(std::size_t i) {
    for (int round = 0; round < k_slip_begin_rounds; ++round) {
      const Vec3 rate = slip_rate(i);
      if (!(norm(rate) > 0)) return false;
      const Vec3 direction = math::normalized(rate);
      const double off = norm(direction - direction_[i]);
      direction_[i] = direction;
      if (!forces()) return false;
      if (off < k_slip_begin_off) return true;
    }
    return false;
  }

  /// Returns how fast friction at a contact slows the slip there by turning the sphere, in m/s^2.
  /// unbraked_rate() returns the slip's rate of change without this effect.
  double brake_of(std::size_t i) const {
    return contacts_[i].friction * loads_[i] / body_.gyration;
  }
  Vec3 unbraked_rate(std::size_t i) const { return slip_rate(i) + brake_of(i) * direction_[i]; }

  /// When a slip begins, friction's direction may be approximate for a while. Returns how long.
  /// After this time, the slip is too fast to stick again.
  double short_while_s(std::size_t i) const {
    const double rate = norm(slip_rate(i));
    return std::max(k_slip_begin_s, rate > 0 ? 2 * body_.stick_mps / rate : 0);
  }

  /// Sets how long the motion lasts. Sets each slip's direction to its direction at half of this
  /// time.
  void hold_directions() {
    double lasts_s = k_forever_s;
    std::array<bool, 2> settled{};
    // The two slips turn each other, so repeat until both directions settle.
    for (int round = 0; round < k_slip_both_rounds && (begins_[0] || begins_[1]); ++round) {
      for (std::size_t i = 0; i < 2; ++i) {
        if (begins_[i]) settled[i] = settle_begin(i);
        if (motion_.pressed != 3) return;
      }
    }
    for (std::size_t i = 0; i < 2; ++i) {
      if (begins_[i] && !settled[i]) lasts_s = std::min(lasts_s, short_while_s(i));
      if (slips_[i] && !begins_[i] && contacts_[i].friction > 0)
        lasts_s = std::min(
            lasts_s,
            held_slip(slip_at(i), unbraked_rate(i), brake_of(i), body_.slip_error_mps()).lasts_s);
    }
    bool turns = false;
    for (std::size_t i = 0; i < 2; ++i) {
      if (!slips_[i] || begins_[i] || contacts_[i].friction == 0) continue;
      const Vec3 half_way = slip_at(i) + (0.5 * std::min(lasts_s, 1.0)) * unbraked_rate(i);
      if (norm(half_way) == 0) continue;
      direction_[i] = math::normalized(half_way);
      turns = true;
    }
    if (turns && !forces()) return;
    // If friction would push a beginning slip along its direction, this contact gets no friction
    // for short_while_s(). Check both contacts twice, because the change may put the other contact
    // into the same state.
    for (int round = 0; round < 2; ++round) {
      for (std::size_t i = 0; i < 2; ++i) {
        if (!begins_[i] || dot(slip_rate(i), direction_[i]) >= 0) continue;
        direction_[i] = Vec3::Zero();
        lasts_s = std::min(lasts_s, short_while_s(i));
        if (!forces()) return;
      }
    }
    for (std::size_t i = 0; i < 2; ++i) {
      if (slips_[i] && !begins_[i] && contacts_[i].friction > 0)
        lasts_s = std::min(lasts_s, stop_s(slip_at(i), slip_rate(i), direction_[i]));
    }
    motion_.lasts_s = lasts_s;
  }

  void set_pressed(const std::array<double, 2>& loads) {
    motion_.pressed = (loads[0] > 0 ? 1U : 0U) | (loads[1] > 0 ? 2U : 0U);
  }

  RoundBody body_;
  std::array<LastingContact, 2> contacts_;
  Vec3 gravity_;
  double cosine_;
  Vec3 line_;                 ///< along the valley
  std::array<Vec3, 2> side_;  ///< in each face, across the valley
  std::array<bool, 2> slips_{};
  std::array<bool, 2> begins_{};  ///< to slip, from rest
  std::array<Vec3, 2> direction_{Vec3::Zero(), Vec3::Zero()};
  std::array<double, 2> loads_{};
  std::array<Vec3, 2> friction_{Vec3::Zero(), Vec3::Zero()};
  ContactMotion motion_;
};

}  // namespace

ContactMotion valley_motion(const RoundBody& body, std::span<const LastingContact> contacts,
                            const Twist& twist, const Vec3& gravity_mps2) {
  return Valley(body, contacts, twist, gravity_mps2).motion();
}

}  // namespace sleight::physics
