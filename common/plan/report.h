// A sampling method's report: named tables of numbers. Archives store the tables unchanged.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace sleight::plan {

/// A table of numbers in row-major order. Its dimensions have names. NaN marks entries that don't
/// apply.
struct Table {
  std::string name;     ///< A plain word.
  std::string meaning;  ///< One sentence.
  std::vector<std::pair<std::string, std::size_t>> dims;
  std::vector<double> values{};
};

/// Dimensions of the same name have the same size in all tables.
struct Report {
  std::vector<Table> tables;
  /// One line that a user of the draws must see, or empty.
  std::string warning;
  bool empty() const { return tables.empty(); }
};

}  // namespace sleight::plan
