// Processes of this machine, read from the kernel's /proc.
//
// Information on another process may be outdated on return. Only children of the caller are safe:
// their process ids aren't reused before the caller waits for them.
//
// Thread safety: any thread.
#pragma once

#include <sys/types.h>

#include <optional>
#include <vector>

#include "service/keeper/attempt_record.h"

namespace sleight::keeper {

/// None if the process doesn't exist. A zombie (ended, but nobody waited for it) still exists.
std::optional<ProcessIdentity> identity_of(pid_t pid);
/// Whether the process runs. A zombie doesn't.
bool is_living(const ProcessIdentity& identity);

/// The process's children in ascending order, zombies included.
std::vector<pid_t> children_of(pid_t pid);

/// Like children_of, but searches all processes: for kernels without lists, and for tests.
std::vector<pid_t> children_by_search(pid_t pid);

/// Whether the process has a child that is not a zombie.
bool has_living_child(pid_t pid);

}  // namespace sleight::keeper
