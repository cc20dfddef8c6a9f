// What an exported file says besides how things look and move: ordered words with values.
//
// Values; thread-safe as any value.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace sleight::gltf {

/// A list is of numbers that belong together: an outcome of several elements.
using ExtraValue = std::variant<bool, std::int64_t, double, std::string, std::vector<double>>;

struct Extra {
  std::string key{};
  ExtraValue value{};
};

/// Written in this order. Numbers that are NaN or infinite become null, as JSON has none; text is
/// made valid UTF-8 without control characters but line ends.
using Extras = std::vector<Extra>;

}  // namespace sleight::gltf
