// Makes draws that spell a word, by any method. Defines the compared quantities.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace sleight::thesis {

/// Compared quantities of a pouring. A faulty sampling method may be wrong in only one quantity.
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

/// Draws by chain.
using Series = std::vector<std::vector<Values>>;

/// Returns a word request's satisfying scans from `first_scan` on. Throws base::Error if invalid.
Series satisfying_draws(const std::string& request_text, std::uint64_t first_scan);

/// Returns all takes of a request that requires at least one take.
std::vector<Values> takes_of(const std::string& request_text);

/// Returns numbers of helped balls by scan. Leaves out chains whose state violates the constraint.
std::vector<std::vector<double>> helped_by_scan(const std::string& request_text);

/// Results of a run that ends by its own stop rule: all counted solutions, and one satisfying draw.
/// The seed chooses the satisfying draw at random. The plan's draws name the counted solutions. If
/// the plan has no draws, each lineage's first satisfying scan counts.
struct Counted {
  bool has_run = false;
  std::vector<Values> solutions;
  std::vector<Values> any_scan;  ///< one; none if no draw is satisfied
};
Counted counted_solutions(const std::string& request_text);

/// Returns how many of `throws` throws of all balls satisfy a word's request.
std::uint64_t satisfying_throws(const std::string& request_text, std::uint64_t throws);

std::uint32_t balls_of(const std::string& request_text);

}  // namespace sleight::thesis
