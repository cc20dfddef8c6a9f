// Options for the service's settings (common/config), shared by `sleight server start` and
// `sleightd`.
#pragma once

#include <CLI/CLI.hpp>
#include <vector>

#include "common/config/settings.h"

namespace sleight::programs {

/// Adds --cores, --memory and so on. Appends the options that the user gives to `given`, in the
/// order of their definition. REQUIRES: `given` outlives the app.
void add_setting_options(CLI::App& app, std::vector<config::Given>& given);

/// Builds the command line of `sleightd`. REQUIRES: `given` outlives the app.
void build_daemon_app(CLI::App& app, std::vector<config::Given>& given);

}  // namespace sleight::programs
