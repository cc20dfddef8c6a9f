// A Plan for the sequential method with `tour_scans`. The plan's chains run islands and restart.
// Each chain makes tours of a fixed number of scans, one after another:
//
//   The first scan is the draw of a free island.
//   The later scans burn the chain in by local moves and islands (worker/run/island_scan.h).
//   Only the last scan is a draw. If this draw satisfies, it is also an independent solution.
//
// First visits to solutions would be biased, because a chain stays long at states of large weight
// but counts each of them once. At a scan fixed beforehand, a burnt-in chain has the model's
// proportions.
// Invariant: the scan at which the run stops is a function of the results up to that scan.
// Not thread-safe.
#pragma once

#include <algorithm>
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
  /// The run ends after this number of scans per chain.
  std::optional<std::uint64_t> scans{};
  /// The run ends at this number of solutions. Solutions are counted when all chains have ended a
  /// tour.
  std::optional<std::uint64_t> independent_solutions{};
};

class RestartedChains final : public plan::Plan {
 public:
  /// REQUIRES: at least one chain; tour_scans >= 2; a limit of scans or solutions.
  explicit RestartedChains(const RestartedChainsOptions& options);

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
  /// A solution is decided at the end of its tour. (Tours have no rounds.)
  std::vector<plan::Solution> solutions_between(std::uint64_t after,
                                                std::uint64_t until) const override;
  std::uint64_t scans_consumed() const override { return behind_.sum(end_); }
  std::optional<std::uint64_t> scans_total() const override;
  /// Reports the free islands of all scans except the tours' first scans. If solutions end the run,
  /// only the first tour's islands count towards the odds.
  plan::Report report() const override;

 private:
  struct Chain {
    std::uint64_t consumed = 0;
    std::uint64_t lineage = 0;
    bool is_out = false;            ///< Whether a unit is handed out.
    std::vector<bool> satisfied{};  ///< By tour: whether the last scan satisfies.
    std::vector<double> log_ps{};   ///< log p_w + log p_c by tour, at its last scan.
    IslandsOfChain islands{};
  };

  std::uint64_t end_of_tour(std::uint64_t tour) const { return (tour + 1) * options_.tour_scans; }
  void judge_tours();

  RestartedChainsOptions options_;
  std::vector<Chain> chains_;
  FurthestBehind behind_;
  std::uint64_t tours_ = 0;  ///< Tours that all chains have ended.
  std::uint64_t solutions_ = 0;
  std::uint64_t end_;
};

}  // namespace sleight::sampling
