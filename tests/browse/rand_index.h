// How far two divisions of a set agree; tests/thesis/alike.py has the same for whole archives.
#pragma once

#include <cstddef>
#include <span>

namespace sleight::browse::testing {

/// The Rand index adjusted for chance: 1 where two divisions are the same, 0 on average where they
/// have nothing to do with each other (L. Hubert and P. Arabie, Journal of Classification 2, 1985,
/// equation 5). 1 where both are trivial in the same way. REQUIRES: a label of each member in both.
double adjusted_rand_index(std::span<const std::size_t> a, std::span<const std::size_t> b);

}  // namespace sleight::browse::testing
