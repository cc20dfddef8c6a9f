// Decides how many free islands a run makes: a pilot, and a batch that estimates the odds.
//
//   island  0            32                              p + n
//           |-- pilot, p --|-- batch, n: estimates P --|-- extended by n / 2 ...
//                     sizes the batch
//
// The pilot has 32 islands. As long as one island exceeds a third of the sum, the spread is
// unreliable. So the pilot then grows by 32 islands at a time, up to 1,024. If all estimates are 0,
// the run ends.
//
// Small pilots mostly miss the largest islands. So the batch is large enough for the requested
// error of log P even if the batch's relative variance is 1.5 times the pilot's. The batch has at
// least math::k_islands_min islands.
//
// If one island exceeds a tenth of the batch's sum, there is no error estimate. The batch then
// grows by half of its first length, repeatedly, up to 32 times its first length.
//
// The pilot determines the number of islands, so its islands must not count. If a run stopped as
// soon as its own estimate looked good, it would miss the rare large islands and underestimate P.
// Extensions have a small bias of this kind: a batch that has a large island grows and dilutes that
// island, but a batch that has no large island stops. docs/MEASUREMENTS quantifies the bias.
// Invariant: the rule's results are a function of the estimates in order. A value type.
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

  /// `log_error` is the requested standard error of log P, in nats. REQUIRES: above 0.
  explicit OddsRule(double log_error) : log_error_(log_error) {}

  /// Adds the next island's log P(satisfied). REQUIRES: !is_over().
  void add(double log_satisfied);

  bool is_over() const { return is_over_; }
  /// Number of islands that are needed as far as known. Once is_over(), the total number.
  std::uint64_t needed() const;
  bool is_sized() const { return batch_islands_ > 0; }
  /// Number of the batch's first island. REQUIRES: is_sized().
  std::uint64_t pilot_islands() const { return pilot_.odds().islands; }
  /// If the rule is over and has a batch, returns the batch's odds. Otherwise, returns the odds
  /// from all islands.
  math::IslandOdds odds() const { return is_over_ && is_sized() ? batch_.odds() : all_.odds(); }

 private:
  void judge_pilot();
  void judge_batch();

  double log_error_;
  math::IslandSums pilot_;
  math::IslandSums batch_;
  math::IslandSums all_;
  std::uint64_t first_islands_ = 0;  ///< Size of the batch before its extension.
  std::uint64_t batch_islands_ = 0;  ///< 0 while undetermined.
  bool is_over_ = false;
};

}  // namespace sleight::sampling
