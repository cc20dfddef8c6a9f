// Decides when a run ends: by scans, by rounds, or by independent solutions at the ends of rounds.
//
// Rounds double: round r, counted from 1, has round_scans * 2^(r-1) scans of every chain (or
// ladder). Solutions are judged at round ends only, so all chains wait there for the slowest chain.
// The other rules need no barrier.
// Invariant: a StopJudge depends only on results before the last round end that it has passed.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "common/plan/plan.h"

namespace sleight::sampling {

/// The first rule that holds ends the run. At least one rule is set.
struct StopRule {
  std::optional<std::uint64_t> scans;  ///< Scans of each chain, the start (scan 0) included.
  std::optional<std::uint32_t> rounds;
  std::optional<std::uint64_t> independent_solutions;  ///< Lineages with a satisfied scan.
};

/// Returns one chain's number of scans in rounds 1 .. rounds. Saturates at the largest count.
std::uint64_t scans_through_round(std::uint64_t round_scans, std::uint32_t rounds);

class StopJudge {
 public:
  static constexpr std::uint64_t k_no_end = std::numeric_limits<std::uint64_t>::max();

  /// `before`: scans before the first round. REQUIRES: round_scans >= 1, at least one rule.
  StopJudge(const StopRule& rule, std::uint64_t round_scans, std::uint64_t before = 0);

  using SolutionsBefore = std::function<std::uint64_t(std::uint64_t scan)>;

  /// Advances over round ends that all chains have reached. `solutions_before(scan)` returns the
  /// number of all chains' lineages that have a solution before that scan.
  void judge(std::uint64_t reached_by_all, const SolutionsBefore& solutions_before);

  /// Scans below this number can be handed out.
  std::uint64_t horizon() const { return horizon_; }
  /// Scan at which the run stops. k_no_end as long as the rules haven't decided it.
  std::uint64_t end() const { return end_; }
  std::optional<std::uint64_t> solutions_wanted() const { return rule_.independent_solutions; }

  /// Rounds with after < end <= until, in scans. All chains share these rounds.
  std::vector<plan::EndedRound> rounds_between(std::uint64_t after, std::uint64_t until) const;

  /// If solutions end the run, returns each chain's minimum number of scans: the first round's
  /// length, or `scans` if that is less. Otherwise, returns nothing.
  std::optional<std::uint64_t> scans_in_any_case() const;

 private:
  std::uint64_t round_end() const { return end_of_round(round_); }
  std::uint64_t end_of_round(std::uint32_t round) const;

  StopRule rule_;
  std::uint64_t round_scans_;
  std::uint64_t before_;
  std::uint32_t round_ = 1;
  std::uint64_t horizon_ = 0;
  std::uint64_t end_ = k_no_end;
};

}  // namespace sleight::sampling
