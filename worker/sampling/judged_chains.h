// A Plan of chains that start from searches and burn in. All chains make their tours together:
//
//   Until there are enough independent solutions:
//     Each chain starts from a search of its own.
//     Each chain makes rounds of round_scans, 2 round_scans, 4 round_scans, ... scans. Rounds end
//       when the last round of all chains is independent of the starts (burn_in_judge.h).
//     If scans of a chain satisfy in that round, one of them is drawn by seed and is the chain's
//       solution.
//
// The scans of the rounds that passed are the draws. Earlier scans and unfinished tours yield no
// draws.
//
// Invariants
//   1. A tour's result is a function of its scans. All chains wait for each other at round ends.
//   2. No chain is excluded or restarted for its own values. Draws come from the round that
//      passed, so its R-hat is subject to selection.
// Memory: the judged values of a tour's scans, until the tour ends. Not thread-safe.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/plan/plan.h"
#include "worker/sampling/burn_in_judge.h"
#include "worker/sampling/furthest_behind.h"

namespace sleight::sampling {

struct JudgedChainsOptions {
  std::uint64_t seed = 0;
  std::uint32_t chains = 1;
  std::uint64_t round_scans = 64;     ///< Length of a tour's first round.
  std::vector<BurnInValue> judged{};  ///< The judged values, in the order of method_values.
  /// The run ends after this number of scans per chain.
  std::optional<std::uint64_t> scans{};
  /// The run ends at this number of solutions. Solutions are counted at the ends of tours.
  std::optional<std::uint64_t> independent_solutions{};
};

class JudgedChains final : public plan::Plan {
 public:
  /// REQUIRES: at least two chains; round_scans >= 4; a limit of scans or solutions.
  explicit JudgedChains(JudgedChainsOptions options);

  std::optional<plan::Unit> next_unit(std::uint32_t scans_max) override;
  void consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
               std::span<const plan::ScanRecord> records) override;
  bool finished() const override { return behind_.least() >= end_; }
  std::uint64_t scans_common() const override { return std::min(behind_.least(), end_); }
  plan::Draws draws() const override;
  std::uint64_t solutions_found() const override { return solutions_; }
  std::optional<std::uint64_t> solutions_wanted() const override {
    return options_.independent_solutions;
  }
  /// A solution is decided at the end of its tour.
  std::vector<plan::Solution> solutions_between(std::uint64_t after,
                                                std::uint64_t until) const override;
  /// Rounds of all tours, numbered consecutively.
  std::vector<plan::EndedRound> rounds_between(std::uint64_t after,
                                               std::uint64_t until) const override;
  std::uint64_t scans_consumed() const override { return behind_.sum(end_); }
  std::optional<std::uint64_t> scans_total() const override;
  /// Tables by tour: begin, end, first judged scan, and each judged value's R-hat.
  plan::Report report() const override;

 private:
  struct Chain {
    std::uint64_t consumed = 0;                 ///< Number of scans, earlier tours included.
    bool is_out = false;                        ///< Whether a unit is handed out.
    std::vector<std::vector<double>> values{};  ///< By judged value, by scan of the tour.
    std::vector<bool> satisfied{};
    std::vector<double> log_ps{};  ///< log p_w + log p_c by scan of the tour.
  };
  struct Tour {
    std::uint64_t begin = 0;
    std::uint64_t judged_from = 0;
    std::uint64_t end = 0;
    std::vector<double> r_hats{};                         ///< R-hat by judged value.
    std::vector<std::optional<std::uint64_t>> counted{};  ///< By chain: the solution's scan.
    std::vector<double> log_ps{};                         ///< By chain: log p_w + log p_c.
  };

  std::uint64_t round_length() const { return options_.round_scans << round_; }
  void judge_rounds();
  /// Returns the current tour if its last round passes.
  std::optional<Tour> burnt_in() const;
  std::vector<std::optional<std::uint64_t>> solutions_of(std::uint64_t judged_from,
                                                         std::uint64_t end) const;

  JudgedChainsOptions options_;
  std::vector<Chain> chains_;
  FurthestBehind behind_;
  std::vector<Tour> tours_{};  ///< Tours that have burnt in.
  std::uint64_t tour_begin_ = 0;
  std::uint32_t round_ = 0;        ///< Round of the current tour.
  std::uint64_t round_begin_ = 0;  ///< First scan of the current round.
  std::vector<std::uint64_t> round_ends_{};
  std::uint64_t end_;
  std::uint64_t solutions_ = 0;
};

}  // namespace sleight::sampling
