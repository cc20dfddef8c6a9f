// Chains that start from a search and burn in, as a Plan. They go on tours, all together:
//
//   until there are enough independent solutions:
//     each chain starts from a search of its own
//     rounds of round_scans, 2 round_scans, 4 round_scans, ... scans, until the last one,
//       judged over all chains, has forgotten how they started (burn_in_judge.h)
//     each chain that satisfied in that round has one solution: a satisfying scan drawn by the seed
//
// The scans of the rounds that passed are the draws; those before are none. A tour that is cut
// short has none either.
//
// Invariants
//   1. What a tour comes to is a function of its results alone; all chains wait for each other at
//      the ends of rounds.
//   2. No chain is left out, or begun again, for how it looks by itself. The round that passes is
//      the one that is drawn from, so its R-hat has chosen it.
// Memory: what is judged of a tour's scans, until it ends.
// Not thread-safe.
#pragma once

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
  std::uint64_t round_scans = 64;     ///< of a tour's first round
  std::vector<BurnInValue> judged{};  ///< the records' method_values
  /// Ends the run after so many scans of each chain; or
  std::optional<std::uint64_t> scans{};
  /// at the end of the tour in which so many solutions are there.
  std::optional<std::uint64_t> independent_solutions{};
};

class JudgedChains final : public plan::Plan {
 public:
  /// REQUIRES: two chains at least; round_scans at least 4; scans or solutions.
  explicit JudgedChains(JudgedChainsOptions options);

  std::optional<plan::Unit> next_unit(std::uint32_t scans_max) override;
  void consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
               std::span<const plan::ScanRecord> records) override;
  bool finished() const override { return behind_.least() >= end_; }
  std::uint64_t scans_common() const override;
  plan::Draws draws() const override;
  std::uint64_t solutions_found() const override { return solutions_; }
  std::optional<std::uint64_t> solutions_wanted() const override {
    return options_.independent_solutions;
  }
  /// Each is decided by the end of its tour.
  std::vector<plan::Solution> solutions_between(std::uint64_t after,
                                                std::uint64_t until) const override;
  /// Of all tours, numbered on.
  std::vector<plan::EndedRound> rounds_between(std::uint64_t after,
                                               std::uint64_t until) const override;
  std::uint64_t scans_consumed() const override { return behind_.sum(end_); }
  std::optional<std::uint64_t> scans_total() const override;
  /// Of tours: when they began, what was judged, R-hat of each value.
  plan::Report report() const override;

 private:
  /// What a chain has made, and the present tour's values.
  struct Chain {
    std::uint64_t consumed = 0;                 ///< scans, those of earlier tours included
    bool is_out = false;                        ///< a unit is handed out
    std::vector<std::vector<double>> values{};  ///< by judged value, by scan of the tour
    std::vector<bool> satisfied{};
    std::vector<double> log_ps{};  ///< log p_w + log p_c, likewise
  };
  struct Tour {
    std::uint64_t begin = 0;
    std::uint64_t judged_from = 0;
    std::uint64_t end = 0;
    std::vector<double> r_hats{};                         ///< by judged value
    std::vector<std::optional<std::uint64_t>> counted{};  ///< by chain: the scan of its solution
    std::vector<double> log_ps{};                         ///< of these
  };

  std::uint64_t round_length() const { return options_.round_scans << round_; }
  /// Judges each round that all chains have reached the end of.
  void judge_rounds();
  /// Whether the round that has just ended passes, as the tour then is.
  std::optional<Tour> burnt_in() const;
  std::vector<std::optional<std::uint64_t>> solutions_of(std::uint64_t judged_from,
                                                         std::uint64_t end) const;

  JudgedChainsOptions options_;
  std::vector<Chain> chains_;
  FurthestBehind behind_;
  std::vector<Tour> tours_{};  ///< that have burnt in
  std::uint64_t tour_begin_ = 0;
  std::uint32_t round_ = 0;        ///< of the present tour
  std::uint64_t round_begin_ = 0;  ///< its first scan
  std::vector<std::uint64_t> round_ends_{};
  std::uint64_t end_;
  std::uint64_t solutions_ = 0;
};

}  // namespace sleight::sampling
