// Slow reference for contact_motion.h: simulates a ball on fixed planes in small time steps.
//
// Idea. Each step adds gravity's impulse and then finds impulses of load, friction and resistance
// that obey their laws at the step's end. This is implicit Euler, as in Moreau, "Unilateral contact
// and dry friction in finite freedom dynamics", 1988. The velocity along each normal is zero.
// Friction of at most mu times the load stops the slip or opposes it. Moments of resistance act on
// the spin in the same way. Projected Gauss-Seidel finds the impulses: it sets each impulse in turn
// to the value that its law requires, given the other impulses. This code has no notion of sliding,
// rolling, valleys or turning directions. The error is of first order in the step.
//
// While the ball rolls, rolling resistance is a moment against the spin. At each contact, this
// moment is at most (1 + k) c r times the load. Rolling resistance acts from the step after the
// first step that ends without slip. On a single plane, a moment against the spin about the normal
// is at most c r times the load. Each step begins without impulses. Otherwise, loads and friction
// across a valley could clamp the ball for no reason. Thread safety: values.
#pragma once

#include <array>
#include <span>

#include "worker/physics/response/contact_motion.h"

namespace sleight::physics::response_reference {

class SteppedBall {
 public:
  /// REQUIRES: the twist moves the ball into no plane, and the ball stays on all planes.
  SteppedBall(const RoundBody& body, std::span<const LastingContact> planes, const Twist& twist,
              const Vec3& gravity_mps2, double step_s);

  void step();

  const Twist& twist() const { return twist_; }
  const Vec3& way_m() const { return way_m_; }
  bool rolls() const { return rolls_; }
  /// Returns whether a plane would have to pull the ball to keep contact. Pulling is not modelled.
  bool pulled() const { return pulled_; }

 private:
  struct Contact {
    LastingContact plane;
    double load = 0;  ///< this step's impulses over the mass
    Vec3 friction = Vec3::Zero();
    Vec3 moment = Vec3::Zero();
    double pivot_moment = 0;
  };

  /// Each sweep returns the largest change of an impulse.
  double sweep_loads();
  double sweep_friction();
  double sweep_resistance();

  std::span<Contact> contacts() { return std::span(contacts_).first(count_); }

  RoundBody body_;
  std::array<Contact, 3> contacts_{};
  std::size_t count_;
  Mat3 loads_of_rates_ = Mat3::Zero();  ///< inverse of the normals' products
  Twist twist_;
  Vec3 way_m_ = Vec3::Zero();
  Vec3 gravity_;
  double step_s_;
  bool rolls_ = false;
  bool pulled_ = false;
};

}  // namespace sleight::physics::response_reference
