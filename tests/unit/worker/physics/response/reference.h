// What the tests of impacts share: random cases, mechanics in extended precision, and slow laws.
//
// The mechanics is written in long double from the textbook formulas, with full matrices, and
// shares nothing with the code under test. Thread safety: pure functions, but Dice.
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

/// EXPECT_NEAR in extended precision.
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

/// Random numbers with a fixed seed.
class Dice {
 public:
  explicit Dice(std::uint64_t seed)
      : stream_({.seed = seed, .purpose = random::Purpose::prior}, 0) {}
  double uniform(double low, double high) { return low + (high - low) * stream_.uniform(); }
  /// The logarithm is uniform.
  double spread(double low, double high) { return low * std::pow(high / low, stream_.uniform()); }
  bool once_in(double count) { return stream_.uniform() * count < 1; }
  Vec3 direction() { return random::UniformDirection3{}.draw(stream_); }
  Quat rotation() { return random::UniformRotation{}.draw(stream_); }

 private:
  random::Stream stream_;
};

/// A body as the textbooks have it. A static one has mass 0 here.
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

/// How wild random_case gets.
struct CaseOptions {
  double moment_ratio_max = 1e4;
  double arm_max = 10;  ///< in radii of gyration
  double mass_ratio_max = 1e6;
  double floor_mps_max = 0;
};
/// Two bodies, or one and static geometry on either side, that approach at the contact.
Case random_case(Dice& dice, const CaseOptions& options);

/// Of the case's bodies with these twists.
Real kinetic_energy(const Case& made, const Twist& a, const Twist& b);
Real3 momentum(const Case& made, const Twist& a, const Twist& b);
/// About the world's origin.
Real3 angular_momentum(const Case& made, const Twist& a, const Twist& b);
/// Velocity of B's contact point relative to A's.
Real3 contact_velocity(const Case& made, const Twist& a, const Twist& b);
/// Sum of speeds at the contact, of translation and rotation: the scale of its rounding.
Real contact_speed_scale(const Case& made, const Twist& a, const Twist& b);
/// (energy after - energy before) / energy before.
Real relative_gain(const Case& made, const ImpactOutput& out);

/// The law of restitution.h from its definition: against the slip where that keeps its sense, else
/// Chatterjee and Ruina's, P_I, P_II by solving with K; kappa and the raised separation speeds by
/// bisection. Deliberate errors can be put in.
enum class Fault : std::uint8_t {
  none,
  uncoupled,   ///< Q is taken to be tangential: its normal component is left out
  unpaid,      ///< the floor of the separation speed is granted without regard to energy
  turned,      ///< friction acts against the slip before the impact even if the slip turns
  slip_unpaid  ///< the floor is granted without regard to energy where friction is against the slip
};
ImpactOutput slow_impact(const Case& made, Fault fault = Fault::none);

/// Newton's restitution with Coulomb friction as commonly used: sticks if the impulse that stops
/// the slip lies in the cone, else friction acts against the slip before the impact. Gains energy.
ImpactOutput plain_newton_impact(const Case& made);

}  // namespace sleight::physics::response_reference
