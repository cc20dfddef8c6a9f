// Compares estimates by islands with estimates by blind throws.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/statistical/support/rank_tests.h"

namespace sleight::statistical {

/// Expects that the means of independent estimates differ by less than 4 combined standard errors.
inline void expect_equal_means(const char* name, const std::vector<double>& islands,
                               const std::vector<double>& throws) {
  const MeanWithError first = mean_of_independent(islands);
  const MeanWithError second = mean_of_independent(throws);
  const double off =
      (first.mean - second.mean) / std::hypot(first.standard_error, second.standard_error);
  fmt::print("{}: islands {:.4g} +- {:.2g}, rejection {:.4g} +- {:.2g}: {:.2f} errors\n", name,
             first.mean, first.standard_error, second.mean, second.standard_error, off);
  EXPECT_LT(std::abs(off), 4) << name;
}

}  // namespace sleight::statistical
