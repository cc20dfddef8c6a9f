// `sleight scene check`: says what a user's scene contains and what happens in it.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "clients/cli/main_app.h"

namespace sleight::programs {

struct SceneArguments {
  std::string path;
  std::vector<std::string> sets;
  std::string drawing;  ///< .svg or .png file; empty: none
  bool json = false;
  std::uint64_t draws = 0;  ///< prior draws; 0: as many as fit into 0.3 s
};

void add_scene_commands(CLI::App& app, SceneArguments& arguments, Action& action);

}  // namespace sleight::programs
