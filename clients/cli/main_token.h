// `sleight token`, `login` and `logout`: the commands for services on other machines.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace sleight::programs {

/// Works like add_service_commands (main_service.h).
void add_token_commands(CLI::App& app, std::function<int()>& action);

}  // namespace sleight::programs
