// `sleight gallery` on the command line.
#pragma once

#include <CLI/CLI.hpp>

#include "clients/cli/main_app.h"
#include "clients/gallery_server/gallery_command.h"

namespace sleight::programs {

/// Adds it; `options` and `action` must outlive the app. `rules`: by which chains are judged.
void add_gallery_command(CLI::App& app, gallery::CommandOptions& options, const cli::Rules& rules,
                         Action& action);

}  // namespace sleight::programs
