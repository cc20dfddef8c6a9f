// Satisfying draws of a word by any method, and their compared quantities.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace sleight::thesis {

/// Compared quantities of a pouring. A sampling method could be wrong in each of them alone.
enum class Quantity : std::uint8_t {
  helped_balls,       ///< number of helped balls
  bin_of_first_ball,  ///< number of the first ball's bin
  bin_of_last_ball,
  log_prior,
  vertex_z,      ///< of a middle partition vertex, m
  drop_x,        ///< of the last ball's drop, m
  drop_distance  ///< from the middle ball's drop to the middle of its bin, m
};
inline constexpr std::array<const char*, 7> k_quantities{
    "helped balls", "bin of first ball", "bin of last ball", "log p", "vertex z",
    "drop x",       "drop distance"};
/// Returns whether a quantity is compared as counts. Other quantities are continuous.
inline constexpr bool is_count(std::size_t quantity) {
  return quantity < 3;
}

using Values = std::array<double, k_quantities.size()>;

/// Series of draws, one for each chain.
using Series = std::vector<std::vector<Values>>;

/// Satisfying scans of a word's request from `first_scan` on. Throws base::Error for a bad request.
Series satisfying_draws(const std::string& request_text, std::uint64_t first_scan);

/// All takes of a request for at least one take.
std::vector<Values> takes_of(const std::string& request_text);

/// Number of helped balls in all satisfying chains, by scan.
std::vector<std::vector<double>> helped_by_scan(const std::string& request_text);

/// Results of a run that ends by its own rule: each counted solution, and a random one of all
/// satisfying draws (by the seed). Counted solutions are those of the plan's draws, or else the
/// first satisfying scan of each lineage.
struct Counted {
  bool has_run = false;
  std::vector<Values> solutions;
  std::vector<Values> any_scan;  ///< one; none if no draw satisfies
};
Counted counted_solutions(const std::string& request_text);

/// Number of throws of all balls, out of `throws`, that satisfy a word's request.
std::uint64_t satisfying_throws(const std::string& request_text, std::uint64_t throws);

std::uint32_t balls_of(const std::string& request_text);

}  // namespace sleight::thesis
