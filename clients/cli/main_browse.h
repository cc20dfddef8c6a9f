// The commands that browse archives: find, groups, compare.
#pragma once

#include <memory>

#include <CLI/CLI.hpp>

#include "clients/cli/compare_command.h"
#include "clients/cli/find_command.h"
#include "clients/cli/groups_command.h"
#include "clients/cli/main_run.h"

namespace sleight::programs {

struct BrowseArguments {
  cli::FindOptions find{};
  cli::GroupsOptions groups{};
  cli::CompareOptions compare{};
};

/// Adds them; `arguments` and `action` must outlive the app.
void add_browse_commands(CLI::App& app, BrowseArguments& arguments, Action& action);

}  // namespace sleight::programs
