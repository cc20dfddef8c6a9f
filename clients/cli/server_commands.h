// `sleight server start|stop|drain|status`: the daemon of this machine.
//
// `start` finds `sleightd` beside this program and starts it in a session of its own, with its
// output in `server.log` of its state folder; it returns when the daemon answers. A daemon that is
// there already is what was asked for.
#pragma once

#include <string>
#include <vector>

#include "clients/report/report.h"
#include "common/config/settings.h"
#include "common/rpc/service.h"

namespace sleight::cli {

struct ServerStartOptions {
  std::vector<config::Given> given{};  ///< settings, handed on to the daemon
  bool foreground = false;             ///< becomes the daemon
  bool json = false;
};

/// Why and how the daemon could not be started is thrown as base::Error, with the end of its log.
int start_server(const ServerStartOptions& options);

/// Ends the daemon and waits until it is gone; jobs run on. Without one it says so.
int stop_server(const std::string& socket, bool json);

/// It starts nothing more, and stops what runs in order.
int drain_server(const std::string& socket, bool json);

int show_server(const std::string& socket, bool json);

/// What `server status` prints.
report::Report server_report(const rpc::ServerView& server, const std::string& socket);

/// The daemon's command line: {"sleightd", "--cores=8"}.
std::vector<std::string> server_command(const std::string& program,
                                        const std::vector<config::Given>& given);

}  // namespace sleight::cli
