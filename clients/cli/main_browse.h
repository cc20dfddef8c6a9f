// The commands that browse archives: find, groups, compare, export and gallery.
#pragma once

#include <CLI/CLI.hpp>

#include "clients/cli/compare_command.h"
#include "clients/cli/export_command.h"
#include "clients/cli/find_command.h"
#include "clients/cli/gallery_command.h"
#include "clients/cli/groups_command.h"
#include "clients/cli/main_app.h"

namespace sleight::programs {

struct BrowseArguments {
  cli::FindOptions find{};
  cli::GroupsOptions groups{};
  cli::CompareOptions compare{};
  cli::ExportAnimationsOptions exported{};
};

/// Adds the commands. REQUIRES: `arguments` and `action` must outlive the app.
void add_browse_commands(CLI::App& app, BrowseArguments& arguments, Action& action);

/// `rules` judge chains. REQUIRES: `options` and `action` must outlive the app.
void add_gallery_command(CLI::App& app, cli::CommandOptions& options, const analysis::Rules& rules,
                         Action& action);

}  // namespace sleight::programs
