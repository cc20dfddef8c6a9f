// Reads the judged draws of an archive's scalars, one scalar of all chains at a time.
//
// Idea. A run may have thousands of scalars and billions of scans, so the amount of work is
// bounded. Only every n-th draw of a scalar is used. The more scalars a run has, the fewer draws of
// each are used. If these draws are independent, they are always enough for the required effective
// sample size. The number of a variable's entries is limited too. Omitted draws make effective
// sample sizes smaller, never larger.
//
// Rank-based measures (R-hat, effective sample sizes) need only an order, so draws without a finite
// value can be used. Both -inf and NaN (entries that don't apply) become one value below all others
// (with_stand_in).
//
// Archives are untrusted: datasets of an unexpected shape throw ExitCode::bad_archive.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/archive/model.h"

namespace sleight::analysis {

/// Maximum draws in memory, for one scalar and for a block of scalars that is read in one pass.
inline constexpr std::uint64_t k_scalar_draws_max = std::uint64_t{1} << 20;
inline constexpr std::uint64_t k_block_draws_max = std::uint64_t{1} << 22;
/// Maximum draws of all scalars together. Judging this many takes about a minute.
inline constexpr std::uint64_t k_all_draws_max = std::uint64_t{1} << 25;
/// Minimum draws used for each scalar and for each chain.
inline constexpr std::uint64_t k_scalar_draws_min = 16384;
inline constexpr std::uint64_t k_chain_draws_min = 256;
/// Maximum chains used. This many chains with k_chain_draws_min draws each have k_scalar_draws_max
/// draws.
inline constexpr std::uint64_t k_chains_max = 4096;

/// The draws `first`, `first` + `stride`, ... in each chain from 0 to `chains` - 1.
struct DrawRange {
  std::uint64_t chains = 1;
  std::uint64_t first = 0;
  std::uint64_t count = 0;  ///< number of draws used
  std::uint64_t stride = 1;
};

/// Chooses among the `available` draws from `first` on. Uses as many draws as the limits allow for
/// this many scalars. REQUIRES: 1 <= chains <= k_chains_max, scalars at least 1.
DrawRange bounded_range(std::uint64_t chains, std::uint64_t first, std::uint64_t available,
                        std::uint64_t scalars);

/// Returns how many scalars can be read with this range.
std::uint64_t scalars_max(const DrawRange& range);

/// A dataset of doubles over (chain, draw, ...).
struct Quantity {
  std::string_view group;
  std::string name;
  std::vector<archive::Dimension> inner{};  ///< dimensions after (chain, draw)
  std::uint64_t entries() const;
  /// Returns "normal_rad" or "normal_rad[2, 0]".
  std::string entry_name(std::uint64_t entry) const;
};

/// Returns the world's variables in /posterior, in order.
std::vector<Quantity> state_variables(const archive::Source& source);

/// Calls `visit` for the entries 0 .. entries-1 in order. Values are ordered by chain, then by
/// draw. REQUIRES: entries is at most quantity.entries().
void for_each_scalar(
    const archive::Source& source, const Quantity& quantity, std::uint64_t entries,
    const DrawRange& range,
    const std::function<void(std::uint64_t entry, std::vector<double>& values)>& visit);

struct StandIns {
  std::uint64_t minus_infinite = 0;
  std::uint64_t nan = 0;
  std::uint64_t all() const { return minus_infinite + nan; }
};

/// Counts -inf and NaN. Replaces both by a value that is far below all others and furthest from the
/// median. If no value is finite, all become 0. Leaves +inf unchanged, since no scalar of Sleight
/// is ever +inf.
StandIns with_stand_in(std::span<double> values);

}  // namespace sleight::analysis
