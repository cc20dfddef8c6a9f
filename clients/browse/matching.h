// Who goes with whom, so that the sum of costs is least: the assignment problem, solved by shortest
// augmenting paths (R. Jonker and A. Volgenant, Computing 38, 1987).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sleight::browse {

/// Solves one problem after another in the same memory.
class CheapestMatching {
 public:
  /// The column of each row; holds until the next call. Of equal sums, which one depends on the
  /// order of rows and columns. REQUIRES: size^2 finite costs, row by row.
  std::span<const std::uint32_t> of(std::span<const double> costs, std::size_t size);

 private:
  void add_row(std::span<const double> costs, std::size_t size, std::size_t row);

  // Rows and columns count from 1, 0 is none.
  std::vector<double> u_{};                 ///< potential by row
  std::vector<double> v_{};                 ///< potential by column
  std::vector<std::size_t> row_of_{};       ///< that a column is matched with
  std::vector<std::uint64_t> came_from_{};  ///< column before a column on its shortest path
  std::vector<double> shortest_{};          ///< path to a column
  std::vector<double> closed_{};     ///< infinity of a column that is in the tree, 0 of others
  std::vector<std::size_t> tree_{};  ///< columns
  std::vector<std::uint32_t> column_of_{};
};

}  // namespace sleight::browse
