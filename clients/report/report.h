// A report formats facts about one thing for people and for programs: each fact has a JSON key and
// a text, defined in one place. Several reports form a table or a JSON list. Thread-safe as any
// value.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "clients/report/text_table.h"
#include "common/json/value.h"

namespace sleight::report {

class Report {
 public:
  /// Adds a fact for both. In a table, columns are aligned to the right, except the first column
  /// and columns without a head. A Column overrides this.
  void add(std::string_view key, json::Value value, std::string_view head, std::string words);
  void add(std::string_view key, json::Value value, Column column, std::string words);
  void for_programs(std::string_view key, json::Value value);
  void for_people(std::string_view head, std::string words);

  /// Returns facts in the order in which they were added.
  const json::Value& as_json() const { return json_; }
  /// Returns a line per fact with text: `indent` spaces, the head padded to a width, the text.
  std::string as_text(std::size_t indent, std::size_t head_width) const;

 private:
  friend TextTable table_of(const std::vector<Report>& rows);

  struct Line {
    Column column;
    std::string words;
  };
  json::Value json_ = json::Value::object();
  std::vector<Line> lines_{};
};

/// Makes a row per report. REQUIRES: all reports have the same heads.
TextTable table_of(const std::vector<Report>& rows);

/// Returns a table whose lines begin with two spaces, for use within a longer text.
std::string indented_table(const std::vector<Report>& rows);

json::Value list_of(const std::vector<Report>& reports);

/// Returns reports of all records. `report_of` takes a record and optionally its index.
template <class Record, class Report_of>
std::vector<Report> reports_of(const std::vector<Record>& records, const Report_of& report_of) {
  std::vector<Report> reports;
  for (const Record& record : records) {
    if constexpr (std::invocable<const Report_of&, const Record&, std::size_t>) {
      reports.push_back(report_of(record, reports.size()));
    } else {
      reports.push_back(report_of(record));
    }
  }
  return reports;
}

}  // namespace sleight::report
