// Figure 2.13: six dice in one picture. Each die has its own table, place and face.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "clients/plot/figure.h"
#include "common/motion/segment.h"

namespace sleight::thesis {

struct DieWish {
  plot::Point place_mm;
  std::uint32_t face = 6;
};

struct DiceOptions {
  std::uint64_t seed = 2000;  ///< of the first die; each next die uses the next seed
  double tolerance_mm = 5;    ///< of a place, with half of it as sigma
  std::uint32_t rounds = 8;   ///< maximum; round r has 50 2^(r-1) scans
  /// Whether faces are numbered after the throw (worker/worlds/dice/numbering.h). Thesis: no.
  bool numbering_free = true;
};

struct ThrownDie {
  DieWish wish;
  std::uint64_t seed = 0;
  /// Motion of the first satisfying animation. The die is numbered as in the figure. Empty: no such
  /// animation.
  std::vector<motion::Segment> motion{};
  std::uint64_t simulations = 0;  ///< at all temperatures, until the first satisfying animation
  std::uint64_t scans = 0;        ///< of the ladder, until the same animation
  double elapsed_s = 0;           ///< of one thread
};

/// Six places in two rows. The dice show 1 to 6.
std::vector<DieWish> dice_wishes();

/// Returns a request for one die. The request uses defaults of the world "dice" and one ladder of
/// parallel tempering.
std::string die_request(const DieWish& wish, std::uint64_t seed, const DiceOptions& options);

/// Runs the request of die `nth` (from 0) until the first satisfying draw at inverse temperature 1.
ThrownDie direct_die(std::uint32_t nth, const DieWish& wish, const DiceOptions& options);

/// Returns a picture of all dice that have an animation. REQUIRES: at least one.
plot::Figure dice_composite(const std::vector<ThrownDie>& dice, const DiceOptions& options);

}  // namespace sleight::thesis
