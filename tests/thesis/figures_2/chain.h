// A chain of Algorithm 2.1 for balls that spell, and records of its iterations.
//
// log p(A) is the formula of A.2.1 without constants:
//   k log lambda - sum over partition vertices of |x|^2 / (2 sd^2) - (active balls) log a,
// with a in square metres.
// Thread safety: pure functions, except that run_chain() increases a counter.
#pragma once

#include <atomic>
#include <cstdint>
#include <utility>
#include <vector>

#include "worker/worlds/spelling/parameters.h"
#include "worker/worlds/spelling/proposals.h"

namespace sleight::thesis {

/// The result of an iteration: numbers of its state, and its proposal.
struct Iteration {
  std::uint32_t filled = 0;  ///< k
  double log_p = 0;          ///< log p(A); -infinity if there is no animation
  double log_p_offsets = 0;  ///< the partition vertices' part of log p(A)
  worlds::spelling::Kind kind = worlds::spelling::Kind::change_all;
  bool accepted = false;
};

struct Chain {
  std::uint32_t balls = 0;     ///< number of designated bins, the largest k
  std::uint32_t vertices = 0;  ///< partition vertices
  std::vector<Iteration> iterations =
      {};  ///< the start, which no proposal made, then all iterations
  /// States of the largest k that the chain reached: the first states of at most k_states_max stays
  /// at this k, then the last state.
  std::vector<worlds::spelling::State> best = {};
};

inline constexpr std::size_t k_states_max = 100;

struct ChainOptions {
  std::uint64_t iterations = 20'000;
  std::uint64_t seed = 2000;
};

/// Runs chain 0 of a request with this seed. Increases `done` by 1 per iteration.
Chain run_chain(const worlds::spelling::Parameters& parameters, const ChainOptions& options,
                std::atomic<std::uint64_t>& done);

/// For each designated bin, the number of its ball, or -1. Bins are in order row by row from the
/// lowest y.
using Order = std::vector<int>;

/// REQUIRES: each state has an animation.
std::vector<Order> orders_of(const worlds::spelling::Parameters& parameters,
                             const std::vector<worlds::spelling::State>& states);

std::uint32_t different_bins(const Order& a, const Order& b);

/// Counts distinct orders. An order counts if it differs from each counted order in at least half
/// of the balls' bins.
std::uint32_t distinct_count(const std::vector<Order>& orders, std::uint32_t balls);

/// Returns the two orders that differ most. REQUIRES: at least one order.
std::pair<Order, Order> most_different(const std::vector<Order>& orders);

}  // namespace sleight::thesis
