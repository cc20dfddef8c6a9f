// `sleight gallery` on the command line.
#pragma once

#include <CLI/CLI.hpp>

#include "clients/cli/gallery_command.h"
#include "clients/cli/main_app.h"

namespace sleight::programs {

/// Adds it; `options` and `action` must outlive the app. `rules`: by which chains are judged.
void add_gallery_command(CLI::App& app, cli::CommandOptions& options, const analysis::Rules& rules,
                         Action& action);

}  // namespace sleight::programs
