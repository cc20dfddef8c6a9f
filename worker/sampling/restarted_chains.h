// Chains of islands that start anew, as a Plan: of sequential, with tour_scans. Each chain goes on
// tours of a fixed number of scans, one after another:
//
//   its first scan is the draw of a free island
//   those after it, local moves and islands (worker/run/island_scan.h), burn it in
//   the last one alone is a draw, and if it satisfies an independent solution
//
// Why solutions are not counted where a chain first comes to them: it stays long at states that
// weigh much, and would count these once, as any other. What it counts would be in proportion to
// how often it leaves them. At a scan that is fixed beforehand a burnt-in chain is in proportion.
//
// Invariant: the scan at which the run stops is a function of the results up to that scan.
// Not thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/plan/plan.h"
#include "worker/sampling/furthest_behind.h"
#include "worker/sampling/island_report.h"

namespace sleight::sampling {

struct RestartedChainsOptions {
  std::uint64_t seed = 0;
  std::uint32_t chains = 1;
  std::uint64_t tour_scans = 2;
  /// Ends the run after so many scans of each chain; or
  std::optional<std::uint64_t> scans{};
  /// at the end of the tour, of all chains, in which so many solutions are there.
  std::optional<std::uint64_t> independent_solutions{};
};

class RestartedChains final : public plan::Plan {
 public:
  /// REQUIRES: a chain; tours of two scans at least; scans or solutions.
  explicit RestartedChains(const RestartedChainsOptions& options);

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
  /// Each is decided by the end of its tour. (Tours have no rounds.)
  std::vector<plan::Solution> solutions_between(std::uint64_t after,
                                                std::uint64_t until) const override;
  std::uint64_t scans_consumed() const override { return behind_.sum(end_); }
  std::optional<std::uint64_t> scans_total() const override;
  /// Of the free islands of all scans but tours' first ones. Those of the first tour tell the odds,
  /// where solutions end the run.
  plan::Report report() const override;

 private:
  struct Chain {
    std::uint64_t consumed = 0;
    std::uint64_t lineage = 0;
    bool is_out = false;            ///< a unit is handed out
    std::vector<bool> satisfied{};  ///< by tour, at its last scan
    std::vector<double> log_ps{};   ///< likewise: log p_w + log p_c
    IslandsOfChain islands{};
  };

  std::uint64_t end_of_tour(std::uint64_t tour) const { return (tour + 1) * options_.tour_scans; }
  /// Moves on over every tour that all chains have ended.
  void judge_tours();

  RestartedChainsOptions options_;
  std::vector<Chain> chains_;
  FurthestBehind behind_;
  std::uint64_t tours_ = 0;  ///< that all chains have ended
  std::uint64_t solutions_ = 0;
  std::uint64_t end_;
};

}  // namespace sleight::sampling
