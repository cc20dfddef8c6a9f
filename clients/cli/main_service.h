// The commands that call the service: submit, list, status, watch, wait, logs, cancel, hold,
// resume, priority, extend, fetch, delete, pin and server. This module adds these commands to the
// command line; submit_command.h, job_commands.h, fetch_command.h and server_commands.h implement
// them.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace sleight::programs {

/// Returns the service's address: a socket's path, or HOST:PORT. Throws base::Error(usage) if
/// settings are wrong.
std::string service_called();

/// Adds the commands. The app owns their arguments. Parsing sets `action` to a function that runs
/// the command and returns the exit code.
void add_service_commands(CLI::App& app, std::function<int()>& action);

}  // namespace sleight::programs
