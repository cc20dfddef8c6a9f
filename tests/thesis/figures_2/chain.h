// One chain of the balls that spell by Algorithm 2.1, kept iteration by iteration.
//
// log p(A) is A.2.1's formula as it stands, without constants:
//   k log lambda - sum over partition vertices of |x|^2 / (2 sd^2) - (active balls) log a,
// with a in square metres.
// Thread safety: pure functions, but for the counter that they raise.
#pragma once

#include <atomic>
#include <cstdint>
#include <utility>
#include <vector>

#include "worker/worlds/spelling/parameters.h"
#include "worker/worlds/spelling/proposals.h"

namespace sleight::thesis {

/// The state after an iteration, and what the iteration did.
struct Iteration {
  std::uint32_t filled = 0;  ///< k
  double log_p = 0;          ///< log p(A); -infinity if there is no animation
  double log_p_offsets = 0;  ///< its part that the partition vertices have
  worlds::spelling::Kind kind = worlds::spelling::Kind::change_all;
  bool accepted = false;
};

struct Chain {
  std::uint32_t balls = 0;                 ///< designated bins: the largest k
  std::uint32_t vertices = 0;              ///< partition vertices
  std::vector<Iteration> iterations = {};  ///< the start, which nothing proposed, and then each
  /// Of the largest k that came up: the first state of each stay (statistics.h), of the first
  /// k_states_max stays, and the last state.
  std::vector<worlds::spelling::State> best = {};
};

inline constexpr std::size_t k_states_max = 100;

struct ChainOptions {
  std::uint64_t iterations = 20'000;
  std::uint64_t seed = 2000;
};

/// Chain 0 of a request with this seed. Raises `done` by 1 with each iteration.
Chain run_chain(const worlds::spelling::Parameters& parameters, const ChainOptions& options,
                std::atomic<std::uint64_t>& done);

/// In which order balls fill the designated bins: by bin, row by row from the lowest y, the number
/// of the ball, -1 if none.
using Order = std::vector<int>;

/// REQUIRES: each state has an animation.
std::vector<Order> orders_of(const worlds::spelling::Parameters& parameters,
                             const std::vector<worlds::spelling::State>& states);

/// Bins that hold another ball, or one in one order alone.
std::uint32_t different_bins(const Order& a, const Order& b);

/// How many of these, counted in turn, differ from all counted before in half of the balls' bins.
std::uint32_t distinct_count(const std::vector<Order>& orders, std::uint32_t balls);

/// The two that differ most. REQUIRES: one at least.
std::pair<Order, Order> most_different(const std::vector<Order>& orders);

}  // namespace sleight::thesis
