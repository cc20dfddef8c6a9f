// Satisfying draws of a word, by whichever way, and what is compared of them.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace sleight::thesis {

/// What is compared of a pouring. By each of them a way of sampling could be wrong alone.
enum class Quantity : std::uint8_t {
  helped_balls,       ///< balls that others helped into their bins
  bin_of_first_ball,  ///< its number
  bin_of_last_ball,
  log_prior,
  vertex_z,      ///< of a partition vertex in the middle, m
  drop_x,        ///< of the last ball, m
  drop_distance  ///< of the middle ball's drop from the middle of the bin that it fills, m
};
inline constexpr std::array<const char*, 7> k_quantities{
    "helped balls", "bin of first ball", "bin of last ball", "log p", "vertex z",
    "drop x",       "drop distance"};
/// Compared as counts; others are continuous.
inline constexpr bool is_count(std::size_t quantity) {
  return quantity < 3;
}

using Values = std::array<double, k_quantities.size()>;

/// Series of draws, one for each chain.
using Series = std::vector<std::vector<Values>>;

/// The satisfying scans of a request of a word, from `first_scan` on. Throws base::Error where the
/// request has errors.
Series satisfying_draws(const std::string& request_text, std::uint64_t first_scan);

/// The takes of a request that asks for some, at least one.
std::vector<Values> takes_of(const std::string& request_text);

/// The helped balls of all chains that satisfy, by scan.
std::vector<std::vector<double>> helped_by_scan(const std::string& request_text);

/// Of a run that ends by its own rule: each solution that it counts (of a plan that says which
/// scans are draws and which of these count, these; else the first satisfying scan of each
/// lineage), and one of all satisfying scans that are draws, by the seed.
struct Counted {
  bool has_run = false;
  std::vector<Values> solutions;
  std::vector<Values> any_scan;  ///< one; none if no scan that is a draw satisfies
};
Counted counted_solutions(const std::string& request_text);

/// How many of so many throws of all balls satisfy a request of a word.
std::uint64_t satisfying_throws(const std::string& request_text, std::uint64_t throws);

/// How many balls a request of a word has.
std::uint32_t balls_of(const std::string& request_text);

}  // namespace sleight::thesis
