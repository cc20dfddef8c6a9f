// The settings of the service (common/config) as options of a command line, for `sleight server
// start` and `sleightd`, which take the same ones.
#pragma once

#include <CLI/CLI.hpp>
#include <vector>

#include "common/config/settings.h"

namespace sleight::programs {

/// Adds --cores, --memory and so on; those that are given are put into `given`, in the order of the
/// command line's options. REQUIRES: `given` lives as long as the app.
void add_setting_options(CLI::App& app, std::vector<config::Given>& given);

/// The command line of `sleightd`: with those options alone. REQUIRES: likewise.
void build_daemon_app(CLI::App& app, std::vector<config::Given>& given);

}  // namespace sleight::programs
