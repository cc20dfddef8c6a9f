// What it means for a world that the simulator stopped.
//
// Thread safety: a pure function.
#pragma once

#include "common/base/bytes.h"
#include "common/plan/failure.h"
#include "worker/physics/scene/scene.h"

namespace sleight::worlds {

/// The failure of a state's simulation; null if bodies overlap at their start, which is no failure
/// but a known outcome.
plan::FailurePointer failure_of(const physics::SceneError& error, base::Bytes state);

}  // namespace sleight::worlds
