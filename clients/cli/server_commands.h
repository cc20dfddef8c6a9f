// `sleight server start|stop|drain|status`: controls this machine's daemon.
//
// `start` finds `sleightd` beside this program and starts it in its own session. The daemon's
// output goes to `server.log` in its state folder. `start` returns when the daemon answers. `start`
// also succeeds if a daemon was already running.
#pragma once

#include <string>
#include <vector>

#include "clients/report/report.h"
#include "common/config/settings.h"
#include "common/rpc/service.h"

namespace sleight::cli {

struct ServerStartOptions {
  std::vector<config::Given> given{};  ///< settings, passed to the daemon
  bool foreground = false;             ///< replaces this process by the daemon
  bool json = false;
};

/// Throws base::Error with the reason and the end of the log if the daemon can't be started.
int start_server(const ServerStartOptions& options);

/// Stops the daemon and waits until it has exited. Jobs keep running. Prints a note if there was no
/// daemon.
int stop_server(const std::string& socket, bool json);

/// Makes the daemon end the running jobs properly and start no others.
int drain_server(const std::string& socket, bool json);

int show_server(const std::string& socket, bool json);

report::Report server_report(const rpc::ServerView& server, const std::string& socket);

/// Returns the daemon's command line, such as {"sleightd", "--cores=8"}.
std::vector<std::string> server_command(const std::string& program,
                                        const std::vector<config::Given>& given);

}  // namespace sleight::cli
