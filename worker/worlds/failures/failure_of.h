// Converts simulator errors to failures.
// Thread safety: a pure function.
#pragma once

#include "common/base/bytes.h"
#include "common/plan/failure.h"
#include "worker/physics/scene/scene.h"

namespace sleight::worlds {

/// Returns the failure of a state's simulation. If bodies overlap at their start, returns null:
/// that is a known outcome.
plan::FailurePointer failure_of(const physics::SceneError& error, base::Bytes state);

}  // namespace sleight::worlds
