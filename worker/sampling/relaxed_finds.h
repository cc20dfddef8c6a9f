// Finds of a search, each relaxed by a chain of its own, as a Plan that ends:
//
//   search for as many finds as takes are wanted
//   relax each: a chain starts from the find and makes so many scans, fixed beforehand
//   a state after the last scan that satisfies is a take; for one that doesn't, another find is
//     searched for and relaxed
//
// A take is never chosen among a chain's scans: it is the state after the last one, or none. Takes
// are the first so many in the order of finds, whoever makes them.
//
// Takes lie near what chains of the target draw; docs/MEASUREMENTS.md has how near. The shares of
// kinds that chains seldom leave stay the search's.
//
// Chain k starts from the find k, both from 0.
// Not thread-safe.
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
  std::uint32_t scans = 1;  ///< after a find, of its chain
};

class RelaxedFinds final : public plan::Plan {
 public:
  /// REQUIRES: the lanes' finds are as many as the takes; takes and scans at least 1.
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

  /// Chains are no draws.
  std::uint64_t scans_common() const override { return 0; }
  std::uint64_t solutions_found() const override { return 0; }
  std::optional<std::uint64_t> solutions_wanted() const override { return std::nullopt; }
  std::vector<plan::Solution> solutions_between(std::uint64_t, std::uint64_t) const override {
    return {};
  }
  bool learns() const override { return false; }

 private:
  struct Chain {
    std::uint64_t scans = 0;  ///< consumed
    bool satisfied = false;   ///< the last of these
    bool is_known = false;    ///< its find counts
    base::Bytes start{};      ///< the find, until the chain has begun
  };
  std::uint64_t chain_length() const { return std::uint64_t{options_.scans} + 1; }
  Chain& chain(std::size_t id);
  /// Gives finds that count now to their chains.
  void begin_chains();
  /// Goes on over the chains that have ended, to the first that hasn't.
  void judge_chains();

  SearchLanes lanes_;
  RelaxedOptions options_;
  std::map<std::uint64_t, base::Bytes> found_ahead_;  ///< by start: finds without a chain
  std::vector<Chain> chains_;
  std::uint64_t known_starts_ = 0;                        ///< starts whose finds have chains
  std::size_t begun_ = 0;                                 ///< chains whose finds are known
  std::set<std::pair<std::uint64_t, std::size_t>> idle_;  ///< of these with nothing out, by scans
  std::size_t judged_ = 0;                                ///< chains that are over, with all before
  std::uint64_t takes_ = 0;                               ///< of these
  std::uint64_t in_vain_ = 0;  ///< of these, the last ones without a take
  std::uint64_t chain_scans_ = 0;
};

}  // namespace sleight::sampling
