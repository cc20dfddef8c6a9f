// A small dense system of linear equations.
//
// Thread safety: a value.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace sleight::physics {

class LinearSystem {
 public:
  static constexpr std::size_t k_most = 4;
  /// REQUIRES: 2 to k_most.
  explicit LinearSystem(std::size_t size) : size_(size) {}

  double& coefficient(std::size_t row, std::size_t column) { return rows_[row][column]; }
  double& right(std::size_t row) { return rows_[row][k_most]; }

  /// Uses Gaussian elimination with the largest pivot in each column. Returns false if a column has
  /// no pivot.
  bool solve(std::array<double, k_most>& unknowns) {
    switch (size_) {
      case 2:
        return solve_for<2>(unknowns);
      case 3:
        return solve_for<3>(unknowns);
      default:
        return solve_for<k_most>(unknowns);
    }
  }

 private:
  template <std::size_t k_size>
  bool solve_for(std::array<double, k_most>& unknowns) {
    for (std::size_t column = 0; column < k_size; ++column) {
      std::size_t pivot = column;
      for (std::size_t row = column + 1; row < k_size; ++row) {
        if (std::fabs(rows_[row][column]) > std::fabs(rows_[pivot][column])) pivot = row;
      }
      if (!(std::fabs(rows_[pivot][column]) > 1e-12)) return false;
      if (pivot != column) std::swap(rows_[pivot], rows_[column]);
      for (std::size_t row = column + 1; row < k_size; ++row) {
        const double share = rows_[row][column] / rows_[column][column];
        for (std::size_t i = column + 1; i < k_size; ++i)
          rows_[row][i] -= share * rows_[column][i];
        rows_[row][k_most] -= share * rows_[column][k_most];
      }
    }
    for (std::size_t row = k_size; row-- > 0;) {
      double sum = rows_[row][k_most];
      for (std::size_t i = row + 1; i < k_size; ++i)
        sum -= rows_[row][i] * unknowns[i];
      unknowns[row] = sum / rows_[row][row];
    }
    return true;
  }

  std::size_t size_;
  std::array<std::array<double, k_most + 1>, k_most> rows_{};
};

}  // namespace sleight::physics
