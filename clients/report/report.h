// A report says what a command found out about one thing, to people and to programs: each fact has
// its key in JSON and its words in one place. Reports of many alike things make a table, or a list
// in JSON.
//
// Values; thread-safe as such.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "clients/report/text_table.h"
#include "common/json/value.h"

namespace sleight::report {

class Report {
 public:
  /// A fact for both. In a table, a column with a head is set to the right, the first column and
  /// one without a head to the left; a Column says it otherwise.
  void add(std::string_view key, json::Value value, std::string_view head, std::string words);
  void add(std::string_view key, json::Value value, Column column, std::string words);
  void for_programs(std::string_view key, json::Value value);
  void for_people(std::string_view head, std::string words);

  /// Facts in the order in which they were added.
  const json::Value& as_json() const { return json_; }
  /// A line for each fact that has words: `indent` spaces, the head, padded to a width, the words.
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

/// A row each. REQUIRES: all have the same heads.
TextTable table_of(const std::vector<Report>& rows);

/// Before each line two spaces, as tables within a longer text have.
std::string indented_table(const std::vector<Report>& rows);

json::Value list_of(const std::vector<Report>& reports);

/// Reports of all of them, by a function of one or of one and its number from 0.
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
