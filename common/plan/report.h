// What a sampling method learnt on its way, as tables of numbers with names: for archives, which
// store them as they are, and for people.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace sleight::plan {

/// A table over named dimensions, row-major; NaN where an entry does not apply.
struct Table {
  std::string name;     ///< a plain word
  std::string meaning;  ///< one sentence
  std::vector<std::pair<std::string, std::size_t>> dims;
  std::vector<double> values;
};

/// One name of a dimension has one size in all tables.
struct Report {
  std::vector<Table> tables;
  /// One line that a user of the draws must know; empty: none.
  std::string warning;
  bool empty() const { return tables.empty(); }
};

}  // namespace sleight::plan
