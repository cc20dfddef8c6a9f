#include "worker/physics/response/contact_motion.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/check.h"
#include "common/math/vector.h"

namespace sleight::physics {
namespace {

using math::cross;
using math::dot;
using math::norm;

constexpr double k_forever_s = std::numeric_limits<double>::infinity();
/// By how much the direction of a slip may turn, in radians, before the motion is asked for again.
constexpr double k_turn = 1.0 / 32;
constexpr double k_turn_max = 0.5;
/// A turn by so much errs by about its square times the slip: more is allowed where that is small.
constexpr double k_slip_error_mps = 1e-5;
/// A slip that would turn by less than this until it ends is straight.
constexpr double k_straight = 1e-9;
/// Of a sum of products.
constexpr double k_rounding = 1e-12;
/// How long a contact that begins to slip does so in a direction that is not quite its own.
constexpr double k_begin_s = 1e-4;
/// Rounds in which that direction is sought, and how well it is found.
constexpr int k_begin_rounds = 40;
constexpr double k_begin_off = 1e-12;

/// In which direction something is braked for now, and how long that direction is good for.
struct Braked {
  Vec3 direction = Vec3::Zero();
  double lasts_s = k_forever_s;
};

/// Of a velocity x whose derivative is now `rate`, without what brakes it: at what it will be half
/// way. REQUIRES: |velocity| > 0.
Braked braked(const Vec3& velocity, const Vec3& rate) {
  const double speed = norm(velocity);
  const Vec3 direction = velocity / speed;
  const double along = dot(rate, direction);
  const double across = norm(rate - along * direction);
  const double stop_s = along < 0 ? speed / -along : k_forever_s;
  if (across * stop_s <= k_straight * speed || across == 0) return {direction, stop_s};
  const double turn = std::clamp(std::sqrt(k_slip_error_mps / speed), k_turn, k_turn_max);
  const double span_s = std::min(turn * speed / across, stop_s);
  return {math::normalized(velocity + (0.5 * span_s) * rate), span_s};
}

/// When a velocity's part along a direction is 0.
double stop_s(const Vec3& velocity, const Vec3& rate, const Vec3& direction) {
  const double along = dot(rate, direction);
  return along < 0 ? std::max(0.0, dot(velocity, direction)) / -along : k_forever_s;
}

/// Resistance to rolling at a speed along a line, as an acceleration: `pull` without it, `most` at
/// most. 0 velocity stays if the resistance can hold it.
double resisted(double velocity, double pull, double most) {
  if (velocity == 0) return std::fabs(pull) <= most ? 0 : pull - std::copysign(most, pull);
  return pull - std::copysign(most, velocity);
}

// ---- one face -----------------------------------------------------------------------------------

/// Brakes the spin about the normal.
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

/// The motion of a sphere that slips in a direction, for so long.
void slide(const RoundBody& body, const LastingContact& contact, const Vec3& pull_mps2,
           double load_mps2, const Braked& slip, ContactMotion& motion) {
  const Vec3 friction = -(contact.friction * load_mps2) * slip.direction;
  motion.acceleration_mps2 = pull_mps2 + friction;
  motion.angular_acceleration_radps2 =
      -cross(contact.normal, friction) / (body.gyration * body.radius_m);
  motion.lasts_s = slip.lasts_s;
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
  Vec3& w = motion.start.angular_velocity_radps;
  v -= dot(v, n) * n;
  const double k = body.gyration;
  const double mobility = 1 + 1 / k;  // of the contact point, against the centre's 1
  const Vec3 slip = v - body.radius_m * cross(w, n);
  if (contact.friction == 0) {
    motion.acceleration_mps2 = pull_mps2;
    brake_pivot(body, contact, load_mps2, motion);
    return motion;
  }
  const double brake = contact.friction * load_mps2 * mobility;
  if (norm(slip) > k_stick_mps) {
    const Vec3 rate = pull_mps2 - brake * math::normalized(slip);
    Braked along = braked(slip, rate);
    along.lasts_s =
        std::min(along.lasts_s, stop_s(slip, pull_mps2 - brake * along.direction, along.direction));
    slide(body, contact, pull_mps2, load_mps2, along, motion);
    brake_pivot(body, contact, load_mps2, motion);
    return motion;
  }

  // It rolls, if friction can turn it as fast as it must.
  const Vec3 impulse = -slip / mobility;
  v += impulse;
  w -= cross(n, impulse) / (k * body.radius_m);
  const double resistance = std::min(contact.rolling_friction, contact.friction) * load_mps2;
  Vec3 a = pull_mps2 / (1 + k);
  double lasts_s = k_forever_s;
  if (resistance > 0) {
    if (norm(v) <= k_stick_mps && norm(a) <= resistance) {
      w -= cross(n, v) / body.radius_m;  // the spin that belongs to the velocity
      v = Vec3::Zero();
      a = Vec3::Zero();
    } else if (norm(v) <= k_stick_mps) {
      a -= resistance / norm(a) * a;
    } else {
      const Braked along = braked(v, a - resistance * math::normalized(v));
      a -= resistance * along.direction;
      lasts_s = std::min(along.lasts_s, stop_s(v, a, along.direction));
    }
  }
  const Vec3 friction = a - pull_mps2;
  if (norm(friction) > contact.friction * load_mps2) {
    // Too steep, unless it would stick again at once.
    const Vec3 direction = -math::normalized(friction);
    if (dot(pull_mps2, direction) > brake) {
      slide(body, contact, pull_mps2, load_mps2, {direction, k_forever_s}, motion);
      brake_pivot(body, contact, load_mps2, motion);
      return motion;
    }
  }
  motion.rolls = true;
  motion.acceleration_mps2 = a;
  motion.angular_acceleration_radps2 = cross(n, a) / body.radius_m;
  motion.lasts_s = lasts_s;
  brake_pivot(body, contact, load_mps2, motion);
  return motion;
}

// ---- two faces ----------------------------------------------------------------------------------

/// A small dense system of equations.
class LinearSystem {
 public:
  static constexpr std::size_t k_most = 4;
  explicit LinearSystem(std::size_t size) : size_(size) {}

  double& coefficient(std::size_t row, std::size_t column) { return rows_[row][column]; }
  double& right(std::size_t row) { return rows_[row][k_most]; }

  /// By elimination with the greatest pivot of each column. False if there is none.
  bool solve(std::array<double, k_most>& unknowns) {
    for (std::size_t column = 0; column < size_; ++column) {
      std::size_t pivot = column;
      for (std::size_t row = column + 1; row < size_; ++row) {
        if (std::fabs(rows_[row][column]) > std::fabs(rows_[pivot][column])) pivot = row;
      }
      if (!(std::fabs(rows_[pivot][column]) > 1e-12)) return false;
      std::swap(rows_[pivot], rows_[column]);
      for (std::size_t row = column + 1; row < size_; ++row) {
        const double share = rows_[row][column] / rows_[column][column];
        for (std::size_t i = column; i <= k_most; ++i)
          rows_[row][i] -= share * rows_[column][i];
      }
    }
    for (std::size_t row = size_; row-- > 0;) {
      double sum = rows_[row][k_most];
      for (std::size_t i = row + 1; i < size_; ++i)
        sum -= rows_[row][i] * unknowns[i];
      unknowns[row] = sum / rows_[row][row];
    }
    return true;
  }

 private:
  std::size_t size_;
  std::array<std::array<double, k_most + 1>, k_most> rows_{};
};

/// A sphere in a valley. Accelerations and forces are over its mass.
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
      slips_[i] = norm(slip) > k_stick_mps || contacts_[i].friction == 0;
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
  /// Velocity of the sphere's surface at a contact.
  Vec3 slip_at(std::size_t i) const {
    return motion_.start.velocity_mps -
           body_.radius_m * cross(motion_.start.angular_velocity_radps, contacts_[i].normal);
  }

  /// Nothing slips: the only freedom is along the line, with the spin that belongs to it. False if
  /// friction doesn't suffice.
  bool rolls() {
    const double k = body_.gyration;
    const double r = body_.radius_m;
    // Loads of what pulls across; friction across is not needed to hold it.
    const double in_a = dot(gravity_, contacts_[0].normal);
    const double in_b = dot(gravity_, contacts_[1].normal);
    const double sine2 = 1 - cosine_ * cosine_;
    const std::array<double, 2> loads{-(in_a - cosine_ * in_b) / sine2,
                                      -(in_b - cosine_ * in_a) / sine2};
    set_pressed(loads);
    if (motion_.pressed != 3) return true;

    const Vec3 spin_per_mps = (side_[0] + side_[1]) / (r * (1 + cosine_));
    const double inertia = k * r * r * dot(spin_per_mps, spin_per_mps);
    // The rolling motion that is nearest to the present one.
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
    // What the contacts can't take of the resistance is not there: it must not make them slip.
    const double most =
        2 * std::min(contacts_[0].friction * loads[0], contacts_[1].friction * loads[1]);
    if (std::fabs(free_a - pull) <= most) a = std::clamp(a, pull - most, pull + most);
    // Both contacts take the same share of the friction: else the spin would leave the rolling one.
    const double friction = 0.5 * (a - pull);
    for (std::size_t i = 0; i < 2; ++i) {
      if (std::fabs(friction) <= contacts_[i].friction * loads[i] * (1 + k_rounding)) continue;
      slips_[i] = true;
      direction_[i] = -std::copysign(1.0, friction) * line_;
      begins_[i] = true;
    }
    if (slips_[0] || slips_[1]) return false;
    motion_.rolls = true;
    motion_.start = {.velocity_mps = speed * line_, .angular_velocity_radps = speed * spin_per_mps};
    motion_.acceleration_mps2 = a * line_;
    motion_.angular_acceleration_radps2 = a * spin_per_mps;
    if (resistance > 0 && speed * a < 0) motion_.lasts_s = speed / -a;
    return true;
  }

  /// The nearest motion without slip at one contact.
  void stop_slip(std::size_t i) {
    const double r = body_.radius_m;
    Vec3& w = motion_.start.angular_velocity_radps;
    const double along = dot(motion_.start.velocity_mps, line_);
    const double turning = dot(w, side_[i]);
    const double speed = (along + body_.gyration * r * turning) / (1 + body_.gyration);
    motion_.start.velocity_mps = speed * line_;
    w += (speed / r - turning) * side_[i] - dot(w, line_) * line_;
  }

  /// Loads, friction and accelerations for the present slips. False, with `pressed` set, if the
  /// sphere doesn't stay on both faces.
  bool forces() {
    const double k = body_.gyration;
    const bool one_sticks = !slips_[0] || !slips_[1];
    const std::size_t stuck = slips_[0] ? 1 : 0;
    // Unknown: both loads; friction along the line and along the side at a contact that sticks.
    // What each of them does to the centre, and as a force of friction.
    struct Unit {
      Vec3 force;
      std::array<Vec3, 2> friction;
    };
    std::array<Unit, 4> units;
    for (std::size_t i = 0; i < 2; ++i) {
      units[i] = {contacts_[i].normal, {Vec3::Zero(), Vec3::Zero()}};
      if (!slips_[i]) continue;
      units[i].friction[i] = -contacts_[i].friction * direction_[i];
      units[i].force += units[i].friction[i];
    }
    std::size_t count = 2;
    if (one_sticks) {
      for (const Vec3& way : {line_, side_[stuck]}) {
        units[count] = {way, {Vec3::Zero(), Vec3::Zero()}};
        units[count++].friction[stuck] = way;
      }
    }
    // How a unit accelerates the surface at a contact: its force, and -r times its turning.
    const auto surface = [&](const Unit& unit, std::size_t at) {
      Vec3 sum = unit.force;
      for (std::size_t i = 0; i < 2; ++i)
        sum += cross(cross(contacts_[i].normal, unit.friction[i]), contacts_[at].normal) / k;
      return sum;
    };
    LinearSystem system(count);
    for (std::size_t column = 0; column < count; ++column) {
      for (std::size_t i = 0; i < 2; ++i)
        system.coefficient(i, column) = dot(units[column].force, contacts_[i].normal);
      if (!one_sticks) continue;
      const Vec3 at_stuck = surface(units[column], stuck);
      system.coefficient(2, column) = dot(at_stuck, line_);
      system.coefficient(3, column) = dot(at_stuck, side_[stuck]);
    }
    for (std::size_t i = 0; i < 2; ++i)
      system.right(i) = -dot(gravity_, contacts_[i].normal);
    if (one_sticks) {
      system.right(2) = -dot(gravity_, line_);
      system.right(3) = -dot(gravity_, side_[stuck]);
    }
    std::array<double, LinearSystem::k_most> sizes{};
    motion_.pressed = 0;
    if (!system.solve(sizes)) return false;
    loads_ = {sizes[0], sizes[1]};
    set_pressed(loads_);
    if (motion_.pressed != 3) return false;

    motion_.acceleration_mps2 = gravity_;
    motion_.angular_acceleration_radps2 = Vec3::Zero();
    friction_ = {Vec3::Zero(), Vec3::Zero()};
    for (std::size_t column = 0; column < count; ++column) {
      motion_.acceleration_mps2 += sizes[column] * units[column].force;
      for (std::size_t i = 0; i < 2; ++i)
        friction_[i] += sizes[column] * units[column].friction[i];
    }
    for (std::size_t i = 0; i < 2; ++i) {
      motion_.angular_acceleration_radps2 -=
          cross(contacts_[i].normal, friction_[i]) / (k * body_.radius_m);
    }
    return true;
  }

  /// A contact that sticks slips if it would need more friction than it has, unless it would stick
  /// again at once.
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

  /// How the surface at a contact accelerates.
  Vec3 slip_rate(std::size_t i) const {
    return motion_.acceleration_mps2 -
           body_.radius_m * cross(motion_.angular_acceleration_radps2, contacts_[i].normal);
  }

  /// The direction in which a slip begins is the one in which friction against it lets it grow.
  /// False if it isn't found.
  bool settle_begin(std::size_t i) {
    for (int round = 0; round < k_begin_rounds; ++round) {
      const Vec3 rate = slip_rate(i);
      if (!(norm(rate) > 0)) return false;
      const Vec3 direction = math::normalized(rate);
      const double off = norm(direction - direction_[i]);
      direction_[i] = direction;
      if (!forces()) return false;
      if (off < k_begin_off) return true;
    }
    return false;
  }

  /// Slips in the directions that they have half way, and for how long.
  void hold_directions() {
    double lasts_s = k_forever_s;
    for (std::size_t i = 0; i < 2; ++i) {
      if (begins_[i] && !settle_begin(i)) lasts_s = std::min(lasts_s, k_begin_s);
      if (motion_.pressed != 3) return;
      if (slips_[i] && !begins_[i] && contacts_[i].friction > 0)
        lasts_s = std::min(lasts_s, braked(slip_at(i), slip_rate(i)).lasts_s);
    }
    bool turns = false;
    for (std::size_t i = 0; i < 2; ++i) {
      if (!slips_[i] || begins_[i] || contacts_[i].friction == 0) continue;
      const Vec3 half_way = slip_at(i) + (0.5 * std::min(lasts_s, 1.0)) * slip_rate(i);
      if (norm(half_way) == 0) continue;
      direction_[i] = math::normalized(half_way);
      turns = true;
    }
    if (turns && !forces()) return;
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

// ---- three faces --------------------------------------------------------------------------------

ContactMotion in_a_corner(const RoundBody& body, std::span<const LastingContact> contacts,
                          const Twist& twist, const Vec3& gravity_mps2) {
  ContactMotion motion{.pressed = 0, .start = {.velocity_mps = Vec3::Zero()}};
  Vec3& w = motion.start.angular_velocity_radps;
  w = twist.angular_velocity_radps;
  if (norm(w) * body.radius_m < k_stick_mps) w = Vec3::Zero();
  // Friction of the spin takes part in what the faces must carry.
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
  return Valley(body, contacts, twist, gravity_mps2).motion();
}

}  // namespace sleight::physics
