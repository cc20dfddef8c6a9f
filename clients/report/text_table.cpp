#include "clients/report/text_table.h"

#include <algorithm>

#include "common/base/check.h"
#include "common/request/text.h"

namespace sleight::report {
namespace {

constexpr std::size_t k_gap = 2;

struct Shown {
  std::size_t column = 0;
  std::size_t width = 0;
};

std::vector<Shown> columns_with_text(const TextTable& table) {
  std::vector<Shown> shown;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    std::size_t width = 0;
    for (const auto& row : table.rows)
      width = std::max(width, request::character_count(row[c]));
    if (width == 0) continue;
    shown.push_back({c, std::max(width, request::character_count(table.columns[c].head))});
  }
  return shown;
}

/// Returns the table's width if the last column has its minimum width.
std::size_t least_width(const std::vector<Shown>& shown) {
  std::size_t width = 0;
  for (const Shown& s : shown)
    width += s.width + k_gap;
  const std::size_t last = shown.back().width;
  return width - k_gap - last + std::min(last, k_last_column_min);
}

void leave_out(const TextTable& table, std::vector<Shown>& shown, std::size_t width) {
  while (!shown.empty() && table.indent + least_width(shown) > width) {
    const auto rank = [&](const Shown& s) { return table.columns[s.column].rank; };
    const auto least = std::ranges::max_element(shown, {}, rank);
    if (rank(*least) == 0) return;
    shown.erase(least);
  }
}

std::string cut(const std::string& text, std::size_t width) {
  constexpr std::size_t k_dots = 3;
  if (request::character_count(text) <= width) return text;
  if (width <= k_dots) return std::string(width, '.');
  return request::printable(text, width - k_dots);
}

std::string line_of(const std::vector<std::string>& texts, const TextTable& table,
                    const std::vector<Shown>& shown, std::optional<std::size_t> width) {
  std::string line(table.indent, ' ');
  std::size_t used = table.indent;
  for (const Shown& s : shown) {
    const bool is_last = &s == &shown.back();
    std::string text = texts[s.column];
    if (is_last && width) text = cut(text, *width > used ? *width - used : 0);
    const std::string space(s.width - std::min(s.width, request::character_count(text)), ' ');
    const bool to_the_right = table.columns[s.column].to_the_right;
    line += to_the_right ? space + text : text + space;
    used += s.width + k_gap;
    if (!is_last) line += std::string(k_gap, ' ');
  }
  line.erase(line.find_last_not_of(' ') + 1);
  return line + "\n";
}

}  // namespace

std::string to_text(const TextTable& table, std::optional<std::size_t> width) {
  for (const auto& row : table.rows)
    CHECK_EQ(row.size(), table.columns.size());
  std::vector<Shown> shown = columns_with_text(table);
  if (width) leave_out(table, shown, *width);
  if (shown.empty()) return {};
  std::vector<std::string> heads;
  for (const Column& column : table.columns)
    heads.push_back(column.head);
  std::string text = line_of(heads, table, shown, width);
  for (const auto& row : table.rows)
    text += line_of(row, table, shown, width);
  return text;
}

}  // namespace sleight::report
