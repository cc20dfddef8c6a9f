// One running ladder of parallel tempering. The ladder's replicas run on any number of workers, and
// some replicas are ahead of others. tests/tempering/tempering_loop.cpp computes the same results
// in a few lines.
//
// Idea. Replicas keep their states and exchange temperatures. A swap (swap.h) needs only its two
// replicas, so rounds have no internal barrier (swap_flow.h). All replicas wait at a round's end
// for the next round's ladder and proposal scales (ladder_round.h).
//
//   scan s of all levels
//     level 0 --+                 the hottest draws from the prior, and begins a lineage
//     level 1 --+-- swap?         s even
//     level 2 --+
//     level 3 --+-- swap?
//
// If a round has more levels than the last, new replicas start from prior draws and become the
// hottest. If a round has fewer levels, the hottest replicas are removed.
//
// Invariants
//   1. The ladder's behaviour is a function of the results, not of their order of delivery.
//   2. A round's ladder and proposal scales depend on earlier rounds alone.
//   3. Each swap's random number has the address (seed, chain, pair of levels, scan).
// Not thread-safe.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "common/plan/block.h"
#include "common/plan/plan.h"
#include "worker/sampling/chain_part.h"
#include "worker/sampling/index_process.h"
#include "worker/sampling/ladder_round.h"
#include "worker/sampling/solutions.h"
#include "worker/sampling/swap_flow.h"

namespace sleight::sampling {

class LadderRun {
 public:
  explicit LadderRun(const LadderOptions& options);

  /// Returns a unit of the replica that is furthest behind, or nothing if no more replicas can run.
  /// `horizon`: scans below this number may begin.
  std::optional<plan::Unit> next_unit(std::uint64_t horizon, std::uint32_t scans_max = 1);
  /// Returns a block. The block has the unit that next_unit() would return, and runnable units of
  /// neighbouring levels as the limits allow. With at least one ladder per thread, a block has a
  /// whole ladder, so no swap waits and no state travels. Otherwise a block has half a thread's
  /// share of the levels.
  std::optional<plan::Block> next_block(std::uint64_t horizon, const plan::BlockLimits& limits,
                                        std::size_t ladders = 1);
  void consume(base::ReplicaId replica, std::uint64_t first_scan,
               std::span<const plan::ScanRecord> records);

  /// Number of scans that every level has completed.
  std::uint64_t scans() const;
  std::uint64_t records_consumed() const { return records_; }
  /// Number of all levels' records. Scans count only if every level has completed them.
  std::uint64_t records_counted() const;
  std::uint64_t round_trips() const;
  const Solutions& solutions() const { return solutions_.front().since; }
  /// The lineages' solutions in scans from `first_scan` on. REQUIRES: replicas start from searches;
  /// a round that has begun starts at `first_scan`.
  const Solutions& solutions_since(std::uint64_t first_scan) const;
  /// The first scan at which all levels' states descend from prior draws. While a state descends
  /// from a find, this is scans().
  std::uint64_t searched_until() const { return searched_until_; }
  /// Rounds with after < end <= until, in scans. REQUIRES: every level has `until` scans.
  std::vector<plan::EndedRound> rounds_between(std::uint64_t after, std::uint64_t until) const;
  /// All rounds; the last is the current one.
  const std::vector<RoundReport>& rounds() const { return rounds_; }
  /// The index process of the scans that every level has completed. Annealing scans are excluded.
  const IndexProcess& index_process() const { return index_process_; }
  std::uint32_t replicas() const { return static_cast<std::uint32_t>(replicas_.size()); }
  /// Result of the burn-in. The next method starts from it. REQUIRES: a round has just ended.
  BurnIn burn_in() const;

 private:
  static constexpr std::uint32_t k_nobody = UINT32_MAX;
  enum class Way : std::uint8_t { unknown, up, down };  ///< Towards coolest, or back.

  using Result = plan::ScanRecord;  ///< The fields of the record that ladders need.
  struct Replica {
    bool lives = false;              ///< Whether the replica has or had a level.
    std::uint64_t first_scan = 0;    ///< First scan of the replica.
    std::uint64_t next_scan = 0;     ///< The next scan whose result is consumed.
    std::uint32_t level = k_nobody;  ///< Level at next_scan, once known.
    bool handed_out = false;
    std::uint64_t lineage = 0;
    std::deque<Result> waiting;  ///< Results from next_scan on.
    Way way = Way::unknown;
  };
  /// A scan that at least one level has not completed.
  struct Row {
    std::vector<std::uint32_t> replica;  ///< Replica by level; k_nobody while unknown.
    std::vector<std::optional<Result>> result;
  };

  struct Stretch {
    std::uint32_t first = 0;
    std::uint32_t end = 0;  ///< One past the last level.
    std::uint32_t size() const { return end - first; }
  };
  struct BlockEnd {
    std::uint64_t end_scan = 0;
    std::uint32_t scans_max = 1;
  };

  const std::vector<double>& ladder() const { return rounds_.back().ladder(); }
  std::uint32_t levels() const { return static_cast<std::uint32_t>(ladder().size()); }
  std::uint64_t round_end() const { return rounds_.back().end_scan(); }

  // Incoming results (ladder_run.cpp).
  Row& row(std::uint64_t scan);
  void place(std::uint32_t replica, std::uint32_t level, std::uint64_t scan);
  void settle(std::vector<std::uint32_t>& ready);
  bool began_by_search(std::uint64_t lineage) const;
  void retire();
  void count_trip(std::uint32_t replica, std::uint32_t level);
  void begin_round(std::vector<std::uint32_t>& ready);
  std::vector<std::uint32_t> replicas_of_new_round();

  // Outgoing work (ladder_blocks.cpp).
  bool may_run(std::uint32_t replica, std::uint64_t horizon) const;
  std::uint32_t furthest_behind(std::uint64_t horizon) const;
  plan::Unit anneal(std::uint32_t id, std::uint32_t scans_max) const;
  plan::Unit scan_of(std::uint32_t replica) const;
  std::uint64_t whole_rows_end(std::span<const std::uint32_t> ready, std::uint64_t end_scan,
                               std::uint64_t scans_max) const;
  std::vector<std::uint32_t> ready_by_level(std::uint64_t horizon) const;
  static Stretch joined(std::span<const std::uint32_t> ready, std::uint32_t level,
                        std::uint64_t wanted);
  plan::Block block_of(std::span<const std::uint32_t> ready, const Stretch& stretch,
                       const BlockEnd& end);

  LadderOptions options_;
  std::vector<Replica> replicas_;
  std::deque<Row> rows_;  ///< Rows from scan retired_ on.
  std::uint64_t retired_ = 0;
  std::uint64_t records_ = 0;
  std::uint64_t records_counted_ = 0;  ///< Records of completed rows.
  std::vector<RoundReport> rounds_;
  IndexProcess index_process_;
  SwapFlow flow_;  ///< Swaps of the current round.
  struct SolutionsSince {
    std::uint64_t first_scan = 0;
    Solutions since{};
  };
  /// Solutions since the start. If replicas start from searches, solutions since each round's start
  /// are stored too.
  std::vector<SolutionsSince> solutions_{1};
  std::uint64_t searched_until_ = 0;
};

}  // namespace sleight::sampling
