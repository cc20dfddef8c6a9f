// Solves the assignment problem: match rows with columns at the least sum of costs. Algorithm:
// shortest augmenting paths (Jonker and Volgenant, Computing 38, 1987).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sleight::browse {

/// A solver that reuses its memory from one problem to the next.
class CheapestMatching {
 public:
  /// Returns the column of each row, valid until the next call. If several matchings have the least
  /// sum, the order of rows and columns decides. REQUIRES: size^2 finite costs, row by row.
  std::span<const std::uint32_t> of(std::span<const double> costs, std::size_t size);

 private:
  void add_row(std::span<const double> costs, std::size_t size, std::size_t row);

  // Rows and columns count from 1; 0 means none.
  std::vector<double> u_{};                 ///< potential by row
  std::vector<double> v_{};                 ///< potential by column
  std::vector<std::size_t> row_of_{};       ///< row matched with a column
  std::vector<std::uint64_t> came_from_{};  ///< previous column on a column's shortest path
  std::vector<double> shortest_{};          ///< length of the shortest path to a column
  std::vector<double> closed_{};            ///< infinity if the column is in the tree, otherwise 0
  std::vector<std::size_t> tree_{};         ///< columns in the tree
  std::vector<std::uint32_t> column_of_{};
};

}  // namespace sleight::browse
