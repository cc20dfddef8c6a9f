#include "worker/worlds/failures/failure_of.h"

#include <utility>

#include "common/base/check.h"

namespace sleight::worlds {
namespace {

plan::FailureKind kind_of(physics::SceneError::Kind kind) {
  using Kind = physics::SceneError::Kind;
  switch (kind) {
    case Kind::search_gave_up:
      return plan::FailureKind::search_gave_up;
    case Kind::too_many_collisions:
      return plan::FailureKind::too_many_collisions;
    case Kind::impact_unresolved:
      return plan::FailureKind::impact_unresolved;
    case Kind::spins_too_long:
      return plan::FailureKind::spins_too_long;
    case Kind::work_limit:
      return plan::FailureKind::work_limit;
    case Kind::bad_number:
    case Kind::bad_mass:
    case Kind::bad_shape:
    case Kind::bad_reference:
    case Kind::no_balance:
      return plan::FailureKind::scene_refused;
    case Kind::overlap:             // a known outcome, handled above
    case Kind::incomplete_history:  // handled by simulating again in full
      break;
  }
  base::check_failed("the failure comes from the simulator", "");
}

}  // namespace

plan::FailurePointer failure_of(const physics::SceneError& error, base::Bytes state) {
  if (error.kind == physics::SceneError::Kind::overlap) return nullptr;
  return std::make_shared<const plan::SimulationFailure>(plan::SimulationFailure{
      .kind = kind_of(error.kind), .message = error.message, .state = std::move(state)});
}

}  // namespace sleight::worlds
