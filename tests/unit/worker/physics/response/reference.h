// Random cases, mechanics in extended precision, and slow laws, shared by the tests of impacts.
//
// The mechanics uses long double, textbook formulas and full matrices. The mechanics shares no code
// with the tested functions. Thread safety: pure functions, except Dice.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>

#include "common/random/angular_distributions.h"
#include "common/random/stream.h"
#include "worker/physics/response/rigid_impact.h"
#include "worker/physics/response/sphere_impact.h"

namespace sleight::physics::response_reference {

using Real = long double;
using Real3 = std::array<Real, 3>;

inline constexpr Real k_epsilon = 0x1p-53L;

inline void expect_near(Real value, Real expected, Real tolerance) {
  EXPECT_LE(std::fabs(value - expected), tolerance) << value << " " << expected;
}

Real3 real(const Vec3& v);
Real3 operator+(const Real3& a, const Real3& b);
Real3 operator-(const Real3& a, const Real3& b);
Real3 operator*(Real factor, const Real3& a);
Real dot(const Real3& a, const Real3& b);
Real norm(const Real3& a);
Real3 cross(const Real3& a, const Real3& b);

class Dice {
 public:
  explicit Dice(std::uint64_t seed)
      : stream_({.seed = seed, .purpose = random::Purpose::prior}, 0) {}
  double uniform(double low, double high) { return low + (high - low) * stream_.uniform(); }
  double spread(double low, double high) { return low * std::pow(high / low, stream_.uniform()); }
  bool once_in(double count) { return stream_.uniform() * count < 1; }
  Vec3 direction() { return random::UniformDirection3{}.draw(stream_); }
  Quat rotation() { return random::UniformRotation{}.draw(stream_); }

 private:
  random::Stream stream_;
};

/// A body as in textbooks. A static body has mass 0.
struct Body {
  Inertia inertia{};
  Pose pose{};
  Twist twist{};
};
struct Case {
  Body a{};
  Body b{};
  Vec3 contact_m = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();
  ContactLaw law{};
};

RigidImpactInput input_of(const Case& made);

struct CaseOptions {
  double moment_ratio_max = 1e4;
  double arm_max = 10;  ///< in radii of gyration
  double mass_ratio_max = 1e6;
  double floor_mps_max = 0;
};
/// Two bodies that approach at the contact. Either body may be static geometry instead.
Case random_case(Dice& dice, const CaseOptions& options);

Real kinetic_energy(const Case& made, const Twist& a, const Twist& b);
Real3 momentum(const Case& made, const Twist& a, const Twist& b);
/// Angular momentum about the world's origin.
Real3 angular_momentum(const Case& made, const Twist& a, const Twist& b);
/// Velocity of B's contact point relative to A's contact point.
Real3 contact_velocity(const Case& made, const Twist& a, const Twist& b);
/// Sum of translational and rotational speeds at the contact. Rounding errors are proportional to
/// this sum.
Real contact_speed_scale(const Case& made, const Twist& a, const Twist& b);
/// (energy after - energy before) / energy before.
Real relative_gain(const Case& made, const ImpactOutput& out);

/// Computes the law in restitution.h from its definition. If the slip doesn't reverse, friction
/// acts against the slip. Otherwise, the law is Chatterjee and Ruina's law. P_I and P_II are
/// solutions of linear equations with K. Bisection finds kappa and raised separation speeds. Can
/// include deliberate faults.
enum class Fault : std::uint8_t {
  none,
  uncoupled,   ///< leaves out the normal component of Q
  unpaid,      ///< grants the floor of the separation speed without regard to energy
  turned,      ///< friction acts against the slip before the impact even if the slip turns
  slip_unpaid  ///< grants the floor without regard to energy if friction is against the slip
};
ImpactOutput slow_impact(const Case& made, Fault fault = Fault::none);

/// Newton's restitution with the usual form of Coulomb friction. This law can gain energy. The
/// contact sticks if the impulse that stops the slip is in the cone. Otherwise friction acts
/// against the initial slip.
ImpactOutput plain_newton_impact(const Case& made);

}  // namespace sleight::physics::response_reference
