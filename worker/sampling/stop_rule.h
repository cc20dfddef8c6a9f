// When a run is over, judged logically: by scans, by rounds, or, at the ends of rounds, by
// independent solutions.
//
// Rounds double: round r, from 1, has round_scans * 2^(r-1) scans of every chain (or ladder).
// Solutions are judged at round ends only, so there all chains wait for the last one; the other
// rules need no barrier.
//
// Invariant: what a judge says is a function of the results before the round ends that it passed.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "common/plan/plan.h"

namespace sleight::sampling {

/// The first rule that holds ends the run. At least one is set.
struct StopRule {
  std::optional<std::uint64_t> scans;  ///< of each chain, the start (scan 0) included
  std::optional<std::uint32_t> rounds;
  std::optional<std::uint64_t> independent_solutions;  ///< lineages with a satisfied scan
};

/// The scans of one chain in rounds 1 .. rounds, saturating at the largest count.
std::uint64_t scans_through_round(std::uint64_t round_scans, std::uint32_t rounds);

class StopJudge {
 public:
  static constexpr std::uint64_t k_no_end = std::numeric_limits<std::uint64_t>::max();

  /// `before`: scans that come before the first round. REQUIRES: round_scans at least 1, one rule
  /// at least.
  StopJudge(const StopRule& rule, std::uint64_t round_scans, std::uint64_t before = 0);

  using SolutionsBefore = std::function<std::uint64_t(std::uint64_t scan)>;

  /// Moves on over every round end that all chains have reached. `solutions_before(scan)`: lineages
  /// over all chains that had satisfied before that scan.
  void judge(std::uint64_t reached_by_all, const SolutionsBefore& solutions_before);

  /// Scans of each chain that may be handed out now.
  std::uint64_t horizon() const { return horizon_; }
  /// At which the run stops, as far as the rules tell yet; k_no_end if they don't.
  std::uint64_t end() const { return end_; }
  std::optional<std::uint64_t> solutions_wanted() const { return rule_.independent_solutions; }

  /// Rounds of all chains together that end with after < scans <= until.
  std::vector<plan::EndedRound> rounds_between(std::uint64_t after, std::uint64_t until) const;

  /// Scans that each chain has in any case, where solutions end the run: to the end of the first
  /// round, or of the run if another rule ends it before. None: solutions end nothing.
  std::optional<std::uint64_t> scans_in_any_case() const;

 private:
  std::uint64_t round_end() const { return end_of_round(round_); }
  std::uint64_t end_of_round(std::uint32_t round) const;
  bool has_enough_solutions(const SolutionsBefore& solutions_before) const;

  StopRule rule_;

  std::uint64_t round_scans_;
  std::uint64_t before_;
  std::uint32_t round_ = 1;
  std::uint64_t horizon_ = 0;
  std::uint64_t end_ = k_no_end;
};

}  // namespace sleight::sampling
