// Generates a program's manual pages in the language mdoc(7).
//
// The program and each of its commands have a page: sleight.1, sleight-archive-info.1. Each page
// refers to the pages of the program, the parent command and the subcommands. Pure functions of the
// tree; thread-safe.
#pragma once

#include <string>
#include <vector>

#include "clients/command_tree/command_tree.h"

namespace sleight::command_tree {

struct ManPage {
  std::string file;  ///< such as "sleight-direct.1"
  std::string text;
};

/// Returns all pages. The program's page comes first. `date` has mdoc's form: "November 26, 2026".
std::vector<ManPage> man_pages(const Command& program, const std::string& date);

}  // namespace sleight::command_tree
