// Converts simulator errors to failures.
// Thread safety: a pure function.
#pragma once

#include "common/base/bytes.h"
#include "common/plan/failure.h"
#include "worker/physics/scene/scene.h"

namespace sleight::worlds {

/// Returns the failure of a state's simulation. Null if bodies overlap at their start: that is a
/// known outcome, not a failure.
plan::FailurePointer failure_of(const physics::SceneError& error, base::Bytes state);

}  // namespace sleight::worlds
