// Processes of this machine, read from the kernel's /proc.
//
// What a function returns about another process may already be outdated. Only the process ids of
// the caller's children are reliable: they aren't reused before the caller waits for the children.
//
// Thread safety: any thread.
#pragma once

#include <sys/types.h>

#include <optional>
#include <vector>

#include "service/keeper/attempt_record.h"

namespace sleight::keeper {

/// Returns none if the process doesn't exist. A zombie still exists: it has ended, but nobody has
/// waited for it.
std::optional<ProcessIdentity> identity_of(pid_t pid);
/// Whether the process runs. A zombie doesn't.
bool is_living(const ProcessIdentity& identity);

/// Returns the process's children in ascending order, including zombies.
std::vector<pid_t> children_of(pid_t pid);

/// Returns the same as children_of, but searches all processes. For kernels without lists of
/// children, and for tests.
std::vector<pid_t> children_by_search(pid_t pid);

/// Whether the process has a child that is not a zombie.
bool has_living_child(pid_t pid);

}  // namespace sleight::keeper
