#include "tests/thesis/tables_3/thesis_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>

#include "common/base/error.h"

namespace sleight::thesis {
namespace {

constexpr std::size_t k_columns = 7;
using Numbers = std::array<double, k_columns>;

/// Parses a line of positive numbers. Commas separate the numbers. Returns nothing if the line has
/// another form.
std::optional<Numbers> numbers_of(std::string_view line) {
  Numbers numbers{};
  const char* at = line.data();
  const char* const end = at + line.size();
  for (std::size_t column = 0; column < k_columns; ++column) {
    if (column > 0 && (at == end || *at++ != ',')) return std::nullopt;
    const auto [next, failure] = std::from_chars(at, end, numbers[column]);
    if (failure != std::errc{} || !(numbers[column] > 0) || !std::isfinite(numbers[column]))
      return std::nullopt;
    at = next;
  }
  if (at != end || numbers[0] != std::floor(numbers[0]) || numbers[0] > 1e6) return std::nullopt;
  return numbers;
}

bool is_product(double events, double ms_per_event, double total_s) {
  return std::abs(1e-3 * events * ms_per_event - total_s) <= k_rounding * total_s;
}

}  // namespace

std::vector<Row> read_thesis_table(const std::string& path) {
  std::ifstream file(path);
  if (!file) {
    throw base::Error(
        fmt::format("{}: the thesis's numbers can't be read; run from the project's root, or say "
                    "where they are "
                    "with --reference",
                    path));
  }
  std::vector<Row> rows;
  bool headed = false;
  std::string line;
  for (std::size_t number = 1; std::getline(file, line); ++number) {
    if (line.starts_with('#')) continue;
    const auto refuse = [&](std::string_view reason) {
      return base::Error(base::ExitCode::usage,
                         fmt::format("{}:{}: '{}' {}", path, number, line, reason));
    };
    if (!headed) {
      if (line != k_heading) throw refuse(fmt::format("is not the heading {}", k_heading));
      headed = true;
      continue;
    }
    const std::optional<Numbers> read = numbers_of(line);
    if (!read) throw refuse("is not seven positive numbers, the first an integer");
    const auto& [n, sync_events, sync_ms, sync_s, async_events, async_ms, async_s] = *read;
    if (!is_product(sync_events, sync_ms, sync_s) || !is_product(async_events, async_ms, async_s))
      throw refuse("has events and times that do not fit");
    if (!rows.empty() && n <= rows.back().n) throw refuse("does not grow");
    rows.push_back({.n = static_cast<std::uint32_t>(n),
                    .sync = {.events = sync_events, .total_s = sync_s},
                    .async = {.events = async_events, .total_s = async_s}});
  }
  if (rows.empty()) throw base::Error(base::ExitCode::usage, fmt::format("{}: has no rows", path));
  return rows;
}

const Row& row_of(const std::vector<Row>& table, std::uint32_t n, const std::string& path) {
  const auto row = std::ranges::find(table, n, &Row::n);
  if (row == table.end())
    throw base::Error(base::ExitCode::usage, fmt::format("{}: has no row for n = {}", path, n));
  return *row;
}

}  // namespace sleight::thesis
