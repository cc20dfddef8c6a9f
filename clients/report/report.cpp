#include "clients/report/report.h"

#include <fmt/format.h>

#include <optional>
#include <utility>

#include "common/base/check.h"

namespace sleight::report {

void Report::add(std::string_view key, json::Value value, std::string_view head,
                 std::string words) {
  for_programs(key, std::move(value));
  for_people(head, std::move(words));
}

void Report::add(std::string_view key, json::Value value, Column column, std::string words) {
  for_programs(key, std::move(value));
  lines_.push_back({std::move(column), std::move(words)});
}

void Report::for_programs(std::string_view key, json::Value value) {
  json_[std::string(key)] = std::move(value);
}

void Report::for_people(std::string_view head, std::string words) {
  const bool to_the_right = !lines_.empty() && !head.empty();
  lines_.push_back({{.head = std::string(head), .to_the_right = to_the_right}, std::move(words)});
}

std::string Report::as_text(std::size_t indent, std::size_t head_width) const {
  std::string text;
  for (const Line& line : lines_) {
    if (!line.words.empty())
      text += fmt::format("{:{}}{:<{}}{}\n", "", indent, line.column.head, head_width, line.words);
  }
  return text;
}

TextTable table_of(const std::vector<Report>& rows) {
  TextTable table;
  if (rows.empty()) return table;
  for (const Report::Line& line : rows.front().lines_)
    table.columns.push_back(line.column);
  for (const Report& report : rows) {
    CHECK_EQ(report.lines_.size(), table.columns.size());
    std::vector<std::string>& row = table.rows.emplace_back();
    for (const Report::Line& line : report.lines_)
      row.push_back(line.words);
  }
  return table;
}

std::string indented_table(const std::vector<Report>& rows) {
  TextTable table = table_of(rows);
  table.indent = 2;
  return to_text(table, std::nullopt);
}

json::Value list_of(const std::vector<Report>& reports) {
  json::Value list = json::Value::array();
  for (const Report& report : reports)
    list.push_back(report.as_json());
  return list;
}

}  // namespace sleight::report
