// The commands that speak to the service: submit, list, status, watch, wait, logs, cancel, hold,
// resume, priority, extend, fetch, delete, pin and server. Part of the programs' mains: this is
// their place in the command line; what they do is in submit_command.h, job_commands.h,
// fetch_command.h and server_commands.h.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace sleight::programs {

/// What commands call: a socket's path, or HOST:PORT. Throws base::Error(usage) where settings are
/// wrong.
std::string service_called();

/// Adds the commands. `action` becomes what a parsed one asks for, and returns the exit code; the
/// arguments live as long as the app.
void add_service_commands(CLI::App& app, std::function<int()>& action);

}  // namespace sleight::programs
