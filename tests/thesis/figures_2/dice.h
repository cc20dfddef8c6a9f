// Figure 2.13: six dice, each thrown by itself onto a table of its own, each directed to its own
// place and face, drawn into one picture.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "clients/plot/figure.h"
#include "common/motion/segment.h"

namespace sleight::thesis {

/// What one die is asked for.
struct DieWish {
  plot::Point place_mm;
  std::uint32_t face = 6;
};

struct DiceOptions {
  std::uint64_t seed = 2000;  ///< of the first die; each next one has the next
  double tolerance_mm = 5;    ///< of a place; its sigma is half of that
  std::uint32_t rounds = 8;   ///< most; round r has 50 2^(r-1) scans
  /// Each face has its turn after the throw (worker/worlds/dice/numbering.h); else dice are
  /// numbered before, as the thesis's are.
  bool numbering_free = true;
};

/// What directing one die came to.
struct ThrownDie {
  DieWish wish;
  std::uint64_t seed = 0;
  /// Of the first satisfying animation, the die's number being its own; none within rounds.
  std::vector<motion::Segment> motion{};
  std::uint64_t simulations = 0;  ///< of all temperatures, until then
  std::uint64_t scans = 0;        ///< of the ladder, likewise
  double elapsed_s = 0;           ///< by one thread
};

/// Six places in two rows; the dice show 1 to 6.
std::vector<DieWish> dice_wishes();

/// The request for one die: the defaults of the world "dice", one ladder of parallel tempering.
std::string die_request(const DieWish& wish, std::uint64_t seed, const DiceOptions& options);

/// Runs the request of the n-th die (from 0) until the first draw at inverse temperature 1 that
/// satisfies it.
ThrownDie direct_die(std::uint32_t nth, const DieWish& wish, const DiceOptions& options);

/// All that were found. REQUIRES: one at least.
plot::Figure dice_composite(const std::vector<ThrownDie>& dice, const DiceOptions& options);

}  // namespace sleight::thesis
