// One ladder of parallel tempering as it runs: tests/tempering/tempering_loop.cpp computes the same
// in a few lines; here replicas run ahead of one another, on any number of workers.
//
// Idea. Replicas keep their states and trade temperatures. A swap (swap.h) needs its two replicas
// only, so within a round there is no barrier (swap_flow.h); a round's end waits for all, and there
// the next round's ladder and proposal sizes are learnt (ladder_round.h). Results are put in their
// places (ladder_run.cpp); units and blocks are cut from what may run (ladder_blocks.cpp).
//
//   scan s of all levels
//     level 0 --+                 the hottest draws from the prior, and begins a lineage
//     level 1 --+-- swap?         s even
//     level 2 --+
//     level 3 --+-- swap?
//
// More levels: new replicas are prior draws and become the hottest. Fewer: the hottest go.
//
// Invariants
//   1. What happens is a function of the results, not of the order in which replicas deliver them.
//   2. A round's ladder and proposal scales hang on earlier rounds alone.
//   3. Swaps draw from (seed, chain, the swap's pair of levels, scan): every pair and scan once.
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

  /// A unit that may run now, of a replica that is furthest behind; none if all that may run are
  /// handed out. `horizon`: scans that may be begun.
  std::optional<plan::Unit> next_unit(std::uint64_t horizon, std::uint32_t scans_max = 1);
  /// Such a unit and, as far as the limit goes, those of neighbouring levels that may run now too.
  /// `ladders`: that go on side by side. Where each thread has one, a ladder goes to it whole, so
  /// that no swap waits and no state travels; else a block takes half a thread's share of the
  /// levels.
  std::optional<plan::Block> next_block(std::uint64_t horizon, const plan::BlockLimits& limits,
                                        std::size_t ladders = 1);
  /// REQUIRES: as Plan::consume.
  void consume(base::ReplicaId replica, std::uint64_t first_scan,
               std::span<const plan::ScanRecord> records);

  /// Scans that every level has.
  std::uint64_t scans() const;
  std::uint64_t records_consumed() const { return records_; }
  /// Of these, those of scans that every level has.
  std::uint64_t records_counted() const;
  /// Of all rounds.
  std::uint64_t round_trips() const;
  const Solutions& solutions() const { return solutions_.front().since; }
  /// Of lineages in the scans from a round's first one on. REQUIRES: replicas start from searches;
  /// a round that has begun.
  const Solutions& solutions_since(std::uint64_t first_scan) const;
  /// The first scan at which no level's state descends from where a search has put a replica: all
  /// levels' lineages have then begun at the hottest level, with a draw from the prior. It is as
  /// far as is known: scans() if the last one had some.
  std::uint64_t searched_until() const { return searched_until_; }
  /// Those that end with after < scans <= until. REQUIRES: every level has `until` scans.
  std::vector<plan::EndedRound> rounds_between(std::uint64_t after, std::uint64_t until) const;
  /// All rounds, the present one last.
  const std::vector<RoundReport>& rounds() const { return rounds_; }
  /// Of the scans that every level has, but those that anneal.
  const IndexProcess& index_process() const { return index_process_; }
  std::uint32_t replicas() const { return static_cast<std::uint32_t>(replicas_.size()); }
  /// What another method goes on from. REQUIRES: a round has just ended.
  BurnIn burn_in() const;

 private:
  static constexpr std::uint32_t k_nobody = UINT32_MAX;
  enum class Way : std::uint8_t { unknown, up, down };  ///< to the coolest, or back from there

  using Result = plan::ScanRecord;  ///< as far as it is needed here
  struct Replica {
    bool lives = false;              ///< it has, or had, a level
    std::uint64_t first_scan = 0;    ///< of its life
    std::uint64_t next_scan = 0;     ///< whose result is to be placed
    std::uint32_t level = k_nobody;  ///< at next_scan, once known
    bool handed_out = false;
    std::uint64_t lineage = 0;
    std::deque<Result> waiting;  ///< from next_scan on
    Way way = Way::unknown;
  };
  /// A scan that some level lacks yet.
  struct Row {
    std::vector<std::uint32_t> replica;  ///< by level; k_nobody before that is known
    std::vector<std::optional<Result>> result;
  };

  /// Levels next to each other.
  struct Stretch {
    std::uint32_t first = 0;
    std::uint32_t end = 0;  ///< the first beyond
    std::uint32_t size() const { return end - first; }
  };
  struct BlockEnd {
    std::uint64_t end_scan = 0;
    std::uint32_t scans_max = 1;
  };

  const std::vector<double>& ladder() const { return rounds_.back().ladder(); }
  std::uint32_t levels() const { return static_cast<std::uint32_t>(ladder().size()); }
  std::uint64_t round_end() const { return rounds_.back().end_scan(); }

  // What comes back (ladder_run.cpp).
  Row& row(std::uint64_t scan);
  void place(std::uint32_t replica, std::uint32_t level, std::uint64_t scan);
  void settle(std::vector<std::uint32_t>& ready);
  bool began_by_search(std::uint64_t lineage) const;
  void retire();
  void count_trip(std::uint32_t replica, std::uint32_t level);
  void begin_round(std::vector<std::uint32_t>& ready);
  std::vector<std::uint32_t> replicas_of_new_round();

  // What is handed out (ladder_blocks.cpp).
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
  std::deque<Row> rows_;  ///< from retired_ on
  std::uint64_t retired_ = 0;
  std::uint64_t records_ = 0;
  std::uint64_t records_counted_ = 0;  ///< of rounds
  std::vector<RoundReport> rounds_;
  IndexProcess index_process_;
  SwapFlow flow_;  ///< of the present round
  struct SolutionsSince {
    std::uint64_t first_scan = 0;
    Solutions since{};
  };
  /// From the start on, and, of replicas that start from searches, from each round on.
  std::vector<SolutionsSince> solutions_{1};
  std::uint64_t searched_until_ = 0;
};

}  // namespace sleight::sampling
