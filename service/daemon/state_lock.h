// The lock that admits one daemon per state folder. The lock is a RunLock
// (common/store/run_lock.h), which works on network disks too. Thread safety: that of RunLock.
#pragma once

#include <memory>
#include <string>

#include "common/store/run_lock.h"

namespace sleight::daemon {

/// Locks the folder. If the lock is taken, throws base::Error(conflict) that names the other
/// process.
std::unique_ptr<store::RunLock> lock_state_folder(const std::string& state);

}  // namespace sleight::daemon
