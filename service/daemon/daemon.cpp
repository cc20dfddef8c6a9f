#include "service/daemon/daemon.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>

#include "common/base/error.h"
#include "common/logging/log.h"
#include "common/rpc/server.h"
#include "service/daemon/state_lock.h"

namespace sleight::daemon {
namespace {

/// Makes the folder, readable by its owner alone.
void make_state_folder(const std::string& state) {
  std::error_code reason;
  std::filesystem::create_directories(state, reason);
  if (reason || ::chmod(state.c_str(), 0700) != 0) {
    throw base::Error(fmt::format("{}: the service's folder can't be used: {}", state,
                                  reason ? reason.message() : std::strerror(errno)));
  }
}

}  // namespace

void run_daemon(const DaemonOptions& options) {
  make_state_folder(options.runner.state);
  const std::unique_ptr<store::RunLock> lock = lock_state_folder(options.runner.state);
  rpc::Loop loop;
  std::unique_ptr<rpc::Server> server;
  JobRunner runner(
      loop, options.runner,
      [&](jobs::JobId job) {
        if (server) server->news(rpc::JobId{job.value});
      },
      lock.get());
  Calls calls(loop, runner, options.facts, options.read, [&] { loop.stop(); });
  // Calls are answered from the moment on at which the jobs are taken up again.
  runner.begin();
  server = std::make_unique<rpc::Server>(
      loop, options.socket, calls, rpc::ServerLimits{},
      [](const std::string& words) { logging::warn(words); }, options.group);
  loop.on_stop_signals([&](int) { loop.stop(); });
  logging::info(fmt::format("serving on {}, state in {}, process {}", options.socket,
                            options.runner.state, ::getpid()));
  loop.run();
  server.reset();
  logging::info("stopped; jobs run on, and the next server takes them over");
}

}  // namespace sleight::daemon
