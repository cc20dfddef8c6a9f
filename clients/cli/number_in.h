// Checks an option's value: a decimal number within limits. CLI::Range would read 010 as octal and
// 0x10 as hexadecimal.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>

#include "common/request/text.h"

namespace sleight::programs {

/// Returns the check of an option whose value is from `low` to `high`.
template <class T>
CLI::Validator number_in(T low, T high) {
  const auto check = [low, high](std::string& text) -> std::string {
    const std::string_view digits = std::string_view(text).substr(text.starts_with('-') ? 1 : 0);
    const bool is_decimal = digits.size() < 2 || digits[0] != '0' || digits[1] == '.';
    T value{};
    if (is_decimal && CLI::detail::lexical_cast(text, value) && low <= value && value <= high)
      return {};
    return fmt::format("expected a decimal number from {} to {}, found '{}'", low, high,
                       request::printable(text, 40));
  };
  return {check, CLI::Range(low, high).get_description()};
}

}  // namespace sleight::programs
