// Metadata of an exported file: ordered keys with values. Thread-safe as any value.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace sleight::gltf {

/// A list holds numbers that belong together, such as an outcome of several elements.
using ExtraValue = std::variant<bool, std::int64_t, double, std::string, std::vector<double>>;

struct Extra {
  std::string key{};
  ExtraValue value{};
};

/// Written in this order. NaN and infinity become null, because JSON lacks them. Text is made valid
/// UTF-8 without control characters except line breaks.
using Extras = std::vector<Extra>;

}  // namespace sleight::gltf
