// When a run is over, judged logically: by scans, by rounds, or by independent solutions at the
// ends of rounds.
//
// Rounds double: round r, from 1, has round_scans * 2^(r-1) scans of every chain (or ladder).
// Solutions are judged at round ends only, so there all chains wait for the last one; the other
// rules need no barrier.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>

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

  /// Moves on over every round end that all chains have reached. `solutions_before(scan)`: lineages
  /// over all chains that had satisfied before that scan.
  void judge(std::uint64_t reached_by_all,
             const std::function<std::uint64_t(std::uint64_t)>& solutions_before);

  /// Scans of each chain that may be handed out now.
  std::uint64_t horizon() const { return horizon_; }
  /// At which the run stops, as far as the rules tell yet; k_no_end if they don't.
  std::uint64_t end() const { return end_; }
  std::optional<std::uint64_t> solutions_wanted() const { return rule_.independent_solutions; }

 private:
  StopRule rule_;
  std::uint64_t round_end() const;

  std::uint64_t round_scans_;
  std::uint64_t before_;
  std::uint32_t round_ = 1;
  std::uint64_t horizon_ = 0;
  std::uint64_t end_ = k_no_end;
};

}  // namespace sleight::sampling
