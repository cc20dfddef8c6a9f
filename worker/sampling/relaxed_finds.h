// A Plan that searches, and relaxes each find by the find's own chain:
//
//   Search for one find per requested take.
//   Relax each find: a chain runs a fixed number of scans from the find.
//   The state after the last scan is a take if it satisfies the constraint. Otherwise search for
//     another find.
//
// Only the state after a chain's last scan can be a take, so takes are never selected among scans.
// Takes are counted in the order of finds, regardless of which worker makes them.
//
// Takes are distributed almost like draws of the target; docs/MEASUREMENTS.md quantifies the
// difference. If chains seldom leave a kind of animation, the kind keeps its share among finds.
//
// Chain k starts from find k, both counted from 0. Not thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "common/base/bytes.h"
#include "common/plan/plan.h"
#include "worker/sampling/search_lanes.h"

namespace sleight::sampling {

struct RelaxedOptions {
  std::uint64_t seed = 0;
  std::uint64_t takes = 1;
  std::uint32_t scans = 1;  ///< Scans of each chain after its find.
};

class RelaxedFinds final : public plan::Plan {
 public:
  /// REQUIRES: the lanes request one find for each take; takes >= 1, scans >= 1.
  RelaxedFinds(SearchLanes lanes, const RelaxedOptions& options);

  std::optional<plan::Unit> next_unit(std::uint32_t scans_max) override;
  void consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
               std::span<const plan::ScanRecord> records) override;
  bool finished() const override;
  base::BytesView start_state(plan::ReplicaKey replica) const override;
  plan::Finds finds() const override;
  std::uint64_t starts_done() const override { return lanes_.starts_done(); }
  std::vector<plan::Find> finds_between(std::uint64_t first, std::uint64_t end) const override {
    return lanes_.finds_between(first, end);
  }
  std::uint64_t scans_consumed() const override { return lanes_.starts() + chain_scans_; }
  std::optional<std::uint64_t> scans_total() const override;

  /// Always 0, because relaxing chains yield no draws.
  std::uint64_t scans_common() const override { return 0; }
  bool learns() const override { return false; }

 private:
  struct Chain {
    std::uint64_t scans = 0;  ///< Consumed scans.
    bool satisfied = false;   ///< Whether the last consumed scan satisfies.
    bool is_known = false;    ///< Whether the chain's find counts.
    base::Bytes start{};      ///< The find, until the chain has begun.
  };
  std::uint64_t chain_length() const { return std::uint64_t{options_.scans} + 1; }
  Chain& chain(std::size_t id);
  void begin_chains();
  void judge_chains();

  SearchLanes lanes_;
  RelaxedOptions options_;
  std::map<std::uint64_t, base::Bytes> found_ahead_;  ///< Finds without a chain, by start.
  std::vector<Chain> chains_;
  std::uint64_t known_starts_ = 0;                        ///< Starts whose finds have chains.
  std::size_t begun_ = 0;                                 ///< Chains whose finds are known.
  std::set<std::pair<std::uint64_t, std::size_t>> idle_;  ///< Begun, with no unit out.
  std::size_t judged_ = 0;                                ///< Chains before the first unfinished.
  std::uint64_t takes_ = 0;                               ///< Takes of the judged chains.
  std::uint64_t in_vain_ = 0;                             ///< Judged chains since the last take.
  std::uint64_t chain_scans_ = 0;
};

}  // namespace sleight::sampling
