// A ball on fixed planes by small steps of time: the slow reference of contact_motion.h.
//
// Idea. Each step adds gravity's impulse and then looks for impulses of load, friction and
// resistance that obey their laws at the step's end (implicit Euler, as in J. J. Moreau,
// "Unilateral contact and dry friction in finite freedom dynamics", 1988): no velocity along a
// normal, friction within mu times the load that stops the slip or opposes it, moments of
// resistance likewise. They are found by projected Gauss-Seidel: every impulse in turn is set to
// what its own law wants given the others. Nothing here knows about sliding, rolling, valleys or
// directions that turn. The error is of first order in the step.
//
// Rolling resistance is a moment of at most (1 + k) c r times the load at a contact, against the
// spin, while the ball rolls, i.e. from the step after the one at whose end no contact slipped;
// what brakes spin about the normal of a single plane is one of at most c r times the load. Each
// step begins without impulses, so that loads and friction across a valley don't grip one another
// where nothing makes them.
// Thread safety: values.
#pragma once

#include <array>
#include <span>

#include "worker/physics/response/contact_motion.h"

namespace sleight::physics::response_reference {

class SteppedBall {
 public:
  /// The twist leads into no plane, and the ball stays on all of them.
  SteppedBall(const RoundBody& body, std::span<const LastingContact> planes, const Twist& twist,
              const Vec3& gravity_mps2, double step_s);

  void step();

  const Twist& twist() const { return twist_; }
  const Vec3& way_m() const { return way_m_; }
  bool rolls() const { return rolls_; }
  /// Whether some plane would have had to pull at the ball: then it left that, which is not
  /// modelled here.
  bool pulled() const { return pulled_; }

 private:
  struct Contact {
    LastingContact plane;
    double load = 0;  ///< impulses over the mass, of this step
    Vec3 friction = Vec3::Zero();
    Vec3 moment = Vec3::Zero();
    double pivot_moment = 0;
  };

  /// How much the greatest impulse changed, of each sweep.
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
