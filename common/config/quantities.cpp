#include "common/config/quantities.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <utility>

namespace sleight::config {
namespace {

struct Unit {
  std::string_view name;  ///< lower case
  double factor;
};

constexpr std::array<Unit, 10> k_sizes{{{"", 1},
                                        {"b", 1},
                                        {"kb", 1e3},
                                        {"mb", 1e6},
                                        {"gb", 1e9},
                                        {"tb", 1e12},
                                        {"kib", 1024.0},
                                        {"mib", 1024.0 * 1024},
                                        {"gib", 1024.0 * 1024 * 1024},
                                        {"tib", 1024.0 * 1024 * 1024 * 1024}}};
constexpr std::array<Unit, 4> k_times{{{"", 1}, {"s", 1}, {"m", 60}, {"h", 3600}}};

/// Multiplies the number by its unit's factor. Returns nothing if the number or the unit is
/// invalid.
template <std::size_t n>
std::optional<double> quantity_of(std::string_view text, const std::array<Unit, n>& units) {
  double number = 0;
  const auto [rest, failure] =
      std::from_chars(text.data(), text.data() + text.size(), number, std::chars_format::fixed);
  if (failure != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(rest - text.data()));
  if (text.size() > 1 && text.front() == ' ') text.remove_prefix(1);
  std::string name(text);
  for (char& c : name) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  for (const Unit& unit : units) {
    if (unit.name == name) return number * unit.factor;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::uint64_t> bytes_of(std::string_view text) {
  const std::optional<double> bytes = quantity_of(text, k_sizes);
  if (!bytes || !(*bytes >= 0 && *bytes <= static_cast<double>(k_bytes_max))) return std::nullopt;
  return static_cast<std::uint64_t>(std::round(*bytes));
}

std::optional<double> duration_s_of(std::string_view text) {
  const std::optional<double> duration_s = quantity_of(text, k_times);
  if (!duration_s || !(*duration_s > 0 && *duration_s <= k_duration_s_max)) return std::nullopt;
  return duration_s;
}

std::string bytes_text(std::uint64_t bytes) {
  static constexpr std::array<std::string_view, 5> k_names{"B", "kB", "MB", "GB", "TB"};
  std::size_t unit = 0;
  while (bytes > 0 && bytes % 1000 == 0 && unit + 1 < k_names.size())
    bytes /= 1000, ++unit;
  return fmt::format("{} {}", bytes, k_names[unit]);
}

std::string duration_text(double duration_s) {
  // Use a larger unit only if the time is a multiple of a tenth of that unit. A multiple of a tenth
  // reads back exactly.
  for (const auto& [factor, name] : {std::pair{3600.0, 'h'}, std::pair{60.0, 'm'}}) {
    if (duration_s >= factor && std::fmod(duration_s * 10, factor) == 0)
      return fmt::format("{}{}", duration_s / factor, name);
  }
  return fmt::format("{}s", duration_s);
}

}  // namespace sleight::config
