// One daemon a state folder: its lock is a run's (common/store/run_lock.h), so it holds on network
// disks too.
//
// Thread safety: as RunLock's.
#pragma once

#include <memory>
#include <string>

#include "common/store/run_lock.h"

namespace sleight::daemon {

/// Takes the folder's lock. Throws base::Error: conflict, naming the other process, where it is
/// taken.
std::unique_ptr<store::RunLock> lock_state_folder(const std::string& state);

}  // namespace sleight::daemon
