// The judged draws of an archive's scalars, one scalar of all chains at a time.
//
// Idea. A run may have thousands of scalars and billions of scans. What is looked at is bounded:
// of each scalar every n-th draw, the fewer the more scalars there are but never so few that their
// number alone could not reach the effective sample size that is wanted; and then only so many
// entries of a variable. Draws left out make effective sample sizes smaller, never larger.
//
// Rank-based measures (R-hat, effective sample sizes) need an order alone, so draws without a
// finite value can take part: -inf, and the NaN of an entry that does not apply, become one value
// below all others (with_stand_in).
//
// Archives are untrusted: datasets of another shape are refused with ExitCode::bad_archive.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/archive/model.h"

namespace sleight::analysis {

/// Draws that are held of one scalar; and of a block of scalars that are read in one pass.
inline constexpr std::uint64_t k_scalar_draws_max = std::uint64_t{1} << 20;
inline constexpr std::uint64_t k_block_draws_max = std::uint64_t{1} << 22;
/// Draws of all scalars together: about a minute's work.
inline constexpr std::uint64_t k_all_draws_max = std::uint64_t{1} << 25;
/// However many scalars there are, so many draws of each are looked at, and of each chain.
inline constexpr std::uint64_t k_scalar_draws_min = 16384;
inline constexpr std::uint64_t k_chain_draws_min = 256;
/// Chains that are looked at: with the least draws of each, they make k_scalar_draws_max.
inline constexpr std::uint64_t k_chains_max = 4096;

/// Draws first, first + stride, ... of each of the chains 0 .. chains-1.
struct DrawRange {
  std::uint64_t chains = 1;
  std::uint64_t first = 0;
  std::uint64_t count = 0;  ///< that are taken
  std::uint64_t stride = 1;
};

/// Of the `available` draws from `first` on, as many as the bounds allow with so many scalars.
/// REQUIRES: 1 <= chains <= k_chains_max, scalars at least 1.
DrawRange bounded_range(std::uint64_t chains, std::uint64_t first, std::uint64_t available,
                        std::uint64_t scalars);

/// Scalars of such a range that may be looked at.
std::uint64_t scalars_max(const DrawRange& range);

/// A dataset of doubles over (chain, draw, ...).
struct Quantity {
  std::string_view group;
  std::string name;
  std::vector<archive::Dimension> inner{};  ///< dimensions after (chain, draw)
  std::uint64_t entries() const;
  /// "normal_rad", or "normal_rad[2, 0]".
  std::string entry_name(std::uint64_t entry) const;
};

/// The world's variables in /posterior, in order.
std::vector<Quantity> state_variables(const archive::Source& source);

/// Calls `visit` with the values of the entries 0 .. entries-1 in order: chain by chain, each its
/// draws. REQUIRES: entries at most those of the quantity.
void for_each_scalar(
    const archive::Source& source, const Quantity& quantity, std::uint64_t entries,
    const DrawRange& range,
    const std::function<void(std::uint64_t entry, std::vector<double>& values)>& visit);

/// How many values were -inf or NaN.
struct StandIns {
  std::uint64_t minus_infinite = 0;
  std::uint64_t nan = 0;
  std::uint64_t all() const { return minus_infinite + nan; }
};

/// Counts, and puts in place of each one value so far below the least finite one that it is the
/// least also by distance from the median, as -inf would be. Where none is finite, all become 0.
/// +inf is left alone: no scalar of ours has it.
StandIns with_stand_in(std::span<double> values);

}  // namespace sleight::analysis
