#include "service/daemon/state_lock.h"

#include <fmt/format.h>

#include <fstream>

#include "common/base/error.h"

namespace sleight::daemon {

std::unique_ptr<store::RunLock> lock_state_folder(const std::string& state) {
  try {
    auto lock = std::make_unique<store::RunLock>(state);
    lock->keep();
    return lock;
  } catch (const base::Error& failure) {
    if (failure.exit_code() != base::ExitCode::conflict) throw;
    std::string process;
    std::ifstream(state + "/lock") >> process;
    throw base::Error(base::ExitCode::conflict,
                      fmt::format("{}: in use by another server{}; run `sleight server stop` to "
                                  "stop that server, or `sleight server status` to show its state",
                                  state, process.empty() ? "" : " (process " + process + ")"));
  }
}

}  // namespace sleight::daemon
