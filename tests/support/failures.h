// What property.h and main.cpp of a test program share: which case runs, and what repeats it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sleight::property {

/// What the environment asks for.
struct Asked {
  std::optional<std::uint64_t> only_case;     ///< SLEIGHT_CASE
  std::optional<std::uint64_t> failing_case;  ///< SLEIGHT_FAIL_CASE
  bool all = false;                           ///< SLEIGHT_ALL
  bool long_run = false;                      ///< SLEIGHT_SOAK
};

/// Read once. Throws std::invalid_argument, with a message for people, where it makes no sense.
const Asked& asked();

/// The case that runs now, if any.
std::optional<std::uint64_t> current_case();
void set_current_case(std::optional<std::uint64_t> number);

/// Whether a loop has come to the case that SLEIGHT_CASE names.
bool only_case_was_met();
/// Whether the case of SLEIGHT_FAIL_CASE has run.
bool failing_case_was_met();

/// `SLEIGHT_CASE=17 PROGRAM --gtest_filter=TEST`, with whatever else of the environment it wants.
std::string command_of(std::string_view program, std::string_view test,
                       std::optional<std::uint64_t> number, bool long_run);

/// A program's path as one writes it in the project's folder: from the last folder named build on,
/// or whole.
std::string path_in_project(std::string_view path);

}  // namespace sleight::property
