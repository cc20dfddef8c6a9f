// How many free islands tell the odds, and which: a batch that a pilot has sized.
//
//   island  0            32                              p + n
//           |-- pilot, p --|-- batch, n: these alone tell P --|-- extended by n / 2 ...
//                     sizes the batch
//
// Pilot. 32 islands, and 32 more as long as one has more than a third of their sum: then their
// spread says nothing yet. It ends with 1,024 in any case; if not one of these is above 0, nothing
// more is tried.
//
// Batch. As many as know log P to the error that is asked for, if their relative variance is half
// as large again as the pilot's, since few islands mostly lack the large ones; and as many as an
// error takes at least (math::k_islands_min).
//
// Extension. Where no error can be told of the batch, since one island has more than a tenth of the
// sum, it goes on by half of its first length, again and again, until one can, or until it is 32
// times as long as at first.
//
// The pilot has chosen how many islands there are, so it may not count: a run that ends when its
// own estimate looks good ends before the rare large islands have come, and says too little.
// Extensions have a little of that too: a batch with a large island goes on and so forgets a part
// of it, one that lacks those stops. docs/MEASUREMENTS has how much.
//
// Invariant: what it says is a function of the estimates in order. A value type.
#pragma once

#include <cstdint>

#include "common/math/island_odds.h"

namespace sleight::sampling {

class OddsRule {
 public:
  static constexpr std::uint64_t k_pilot_islands = 32;
  static constexpr std::uint64_t k_pilot_islands_max = 1024;
  static constexpr double k_pilot_share_max = 1.0 / 3;
  static constexpr double k_variance_lacking = 1.5;
  static constexpr std::uint64_t k_batch_growth_max = 32;

  /// `log_error`: of log P, in nats. REQUIRES: above 0.
  explicit OddsRule(double log_error) : log_error_(log_error) {}

  /// The next island's log P(satisfied). REQUIRES: !is_over().
  void add(double log_satisfied);

  bool is_over() const { return is_over_; }
  /// Islands that are needed in any case, by what is known so far; all of them once it is over.
  std::uint64_t needed() const;
  bool is_sized() const { return batch_islands_ > 0; }
  /// The batch's first island. REQUIRES: is_sized().
  std::uint64_t pilot_islands() const { return pilot_.odds().islands; }
  /// Of the batch once the rule is over and has one, else of all so far.
  math::IslandOdds odds() const { return is_over_ && is_sized() ? batch_.odds() : all_.odds(); }

 private:
  void judge_pilot();
  void judge_batch();

  double log_error_;
  math::IslandSums pilot_;
  math::IslandSums batch_;
  math::IslandSums all_;
  std::uint64_t first_islands_ = 0;  ///< of the batch, before it was extended
  std::uint64_t batch_islands_ = 0;  ///< 0: not sized yet
  bool is_over_ = false;
};

}  // namespace sleight::sampling
