// State shared by property.h and a test program's main.cpp.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sleight::property {

struct Asked {
  std::optional<std::uint64_t> only_case;     ///< SLEIGHT_CASE.
  std::optional<std::uint64_t> failing_case;  ///< SLEIGHT_FAIL_CASE.
  bool all = false;                           ///< SLEIGHT_ALL.
  bool long_run = false;                      ///< SLEIGHT_SOAK.
};

/// Reads the settings at the first call. Throws std::invalid_argument if they are invalid.
const Asked& asked();

std::optional<std::uint64_t> current_case();
void set_current_case(std::optional<std::uint64_t> number);

/// Returns whether a loop has reached the case that SLEIGHT_CASE selects.
bool only_case_was_met();
/// Returns whether the case that SLEIGHT_FAIL_CASE selects has run.
bool failing_case_was_met();

/// Returns a command such as `SLEIGHT_CASE=17 PROGRAM --gtest_filter=TEST`. The command includes
/// all other necessary settings.
std::string command_of(std::string_view program, std::string_view test,
                       std::optional<std::uint64_t> number, bool long_run);

/// Returns a program's path from its last `build` folder on, or the whole path.
std::string path_in_project(std::string_view path);

}  // namespace sleight::property
