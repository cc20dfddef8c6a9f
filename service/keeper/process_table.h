// Processes of this machine, as the kernel's /proc tells.
//
// What is read of another process may be of the past when it returns, but for children of the
// caller: their numbers are not used again before the caller has waited for them.
//
// Thread safety: any thread.
#pragma once

#include <sys/types.h>

#include <optional>
#include <vector>

#include "service/keeper/attempt_record.h"

namespace sleight::keeper {

/// None where there is no such process. One that has ended and was not waited for is still there.
std::optional<ProcessIdentity> identity_of(pid_t pid);
/// Whether it runs: one that has ended and is not waited for yet does not.
bool is_living(const ProcessIdentity& identity);

/// Processes whose parent `pid` is, ascending, also those that were not waited for.
std::vector<pid_t> children_of(pid_t pid);

/// The same, by looking at every process: for kernels that don't list children, and for tests.
std::vector<pid_t> children_by_search(pid_t pid);

/// Whether `pid` has a child that has not ended.
bool has_living_child(pid_t pid);

}  // namespace sleight::keeper
