// Manual pages of a program, in the language mdoc(7).
//
// The program and each of its commands has a page: sleight.1, sleight-archive-info.1. All pages of
// a program refer to its own and to those of the commands right above and below.
//
// Pure functions of the tree; thread-safe.
#pragma once

#include <string>
#include <vector>

#include "clients/command_tree/command_tree.h"

namespace sleight::command_tree {

struct ManPage {
  std::string file;  ///< "sleight-direct.1"
  std::string text;
};

/// The pages of a program, its own first. `date` is as mdoc has it: "November 26, 2026".
std::vector<ManPage> man_pages(const Command& program, const std::string& date);

}  // namespace sleight::command_tree
