// A sampling method as a pure plan: which units can run, what follows from their results, when it
// is over. It knows no worker, thread, clock or file. The serial loop, the thread pool and the
// coordinator are executors of the same plan, so no second loop of any method exists.
//
// Invariants
//   1. Units of one replica are handed out in scan order, one at a time.
//   2. What a plan does next is a function of the results consumed, not of their order of arrival
//      across replicas. Which ready unit is handed out first may depend on the executor's asking.
//   3. Consuming the stored results of an earlier session brings a fresh plan to where it was.
// Not thread-safe: one executor drives it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/plan/block.h"
#include "common/plan/report.h"
#include "common/plan/unit.h"

namespace sleight::plan {

/// Consecutive scans that are draws; and of each chain the scan that is its independent solution of
/// these, if it has one.
struct DrawPart {
  std::uint64_t first_scan = 0;
  std::uint64_t count = 0;
  std::vector<std::optional<std::uint64_t>> counted{};
};

/// A chain's draws are its records at inverse temperature 1 from some scan on, by (scan, replica);
/// of these only the ones in parts, where there are parts.
struct Draws {
  std::uint64_t first_scan = 0;
  std::uint64_t count = 0;  ///< in parts: of all together
  std::vector<DrawPart> parts{};
};

/// What searches have found. Starts are numbered; a find counts when all starts before its own are
/// done, so that which finds these are hangs on no worker.
struct Finds {
  std::uint64_t found = 0;
  std::uint64_t wanted = 0;  ///< 0: nothing is searched for
  bool gave_up = false;      ///< too many starts in a row found nothing
  /// Then, for people: at what the best of these were stuck, "ball 3 of 16"; empty if all stages
  /// stood, and only the whole did not end as is wanted.
  std::string stuck_at{};
  bool is_all = false;  ///< no chains that are sampled come after the search
  /// Takes: finds that are relaxed by chains and still end as is wanted.
  std::uint64_t relaxed = 0;
  std::uint64_t relaxed_wanted = 0;  ///< 0: finds are not relaxed

  bool is_searching() const { return found < wanted && !gave_up; }
};

/// A start of a search that found something.
struct Find {
  std::uint64_t start = 0;
  double log_p = 0;  ///< log_prior + log_constraint of its record
};

/// What free islands have said so far of P(satisfied), where that is asked for.
struct Odds {
  bool are_asked = false;
  std::uint64_t islands = 0;  ///< that are done; at last, that tell log_p
  std::uint64_t wanted = 0;   ///< in all; 0: not known yet
  std::optional<double> log_p{};
  std::optional<double> log_error{};  ///< of log_p
  bool is_final = false;              ///< its rule has ended, and the error can be trusted
  friend bool operator==(const Odds&, const Odds&) = default;
};

/// An independent solution of a chain.
struct Solution {
  base::ChainId chain;
  std::uint64_t scan = 0;
  double log_p = 0;           ///< log_prior + log_constraint of its record
  std::uint64_t decided = 0;  ///< it is one as soon as all chains have so many scans
};

/// A round that is over, of one ladder or of all chains together (chain 0).
struct EndedRound {
  base::ChainId chain;
  std::uint64_t round = 0;                     ///< from 1
  std::uint64_t scans = 0;                     ///< that the chain has then
  std::optional<double> swaps{};               ///< mean acceptance, of a ladder
  std::optional<std::uint64_t> round_trips{};  ///< that ended in it, of a ladder
};

class Plan {
 public:
  virtual ~Plan() = default;

  /// The next unit that may run now, of at most `scans_max` scans, and never handed out before;
  /// none when all that could run is handed out or done. The replica that is furthest behind
  /// comes first. REQUIRES: scans_max >= 1.
  virtual std::optional<Unit> next_unit(std::uint32_t scans_max) = 0;

  /// Likewise a block of units: where replicas meet, neighbours together with their swaps. Plans
  /// whose replicas never meet have blocks of one unit.
  virtual std::optional<Block> next_block(const BlockLimits& limits);

  /// The state that a replica starts with, where that is not drawn by its first unit; else empty.
  /// REQUIRES: a unit that starts it is handed out.
  virtual base::BytesView start_state(ReplicaKey /*replica*/) const { return {}; }

  /// Takes in the results of scans [first_scan, first_scan + records.size()) of one replica.
  /// REQUIRES: they continue what was consumed of that replica, and lie in a unit handed out, or
  /// (before the first next_unit) come from a run store.
  virtual void consume(ReplicaKey replica, base::ScanIndex first_scan,
                       std::span<const ScanRecord> records) = 0;

  /// Whether the stop rule holds: nothing more will be handed out.
  virtual bool finished() const = 0;

  /// Scans that every chain has: where an archive written now is cut.
  virtual std::uint64_t scans_common() const = 0;

  /// The draws that every chain has among these scans.
  virtual Draws draws() const { return {.first_scan = 0, .count = scans_common()}; }

  /// Independent solutions so far: lineages with a satisfied scan; and how many end the run, when
  /// the stop rule asks for them.
  virtual std::uint64_t solutions_found() const = 0;
  virtual std::optional<std::uint64_t> solutions_wanted() const = 0;

  /// Of these, the ones with after < decided <= until, by (decided, chain, scan). They are a
  /// function of the results before scan `until`. REQUIRES: until <= scans_common().
  virtual std::vector<Solution> solutions_between(std::uint64_t after,
                                                  std::uint64_t until) const = 0;

  /// Rounds that ended with after < scans <= until, by (scans, chain); likewise.
  virtual std::vector<EndedRound> rounds_between(std::uint64_t /*after*/,
                                                 std::uint64_t /*until*/) const {
    return {};
  }

  virtual Finds finds() const { return {}; }

  /// Starts of the search that are done with all starts before them, up to the one that ended it;
  /// and what those from `first` on found, in order. REQUIRES: end <= starts_done().
  virtual std::uint64_t starts_done() const { return 0; }
  virtual std::vector<Find> finds_between(std::uint64_t /*first*/, std::uint64_t /*end*/) const {
    return {};
  }

  /// Draws from the prior that are done with all before them.
  virtual std::uint64_t prior_draws() const { return 0; }
  virtual std::uint64_t prior_draws_wanted() const { return 0; }

  virtual Odds odds() const { return {}; }

  /// Replicas that went from the prior to inverse temperature 1 and back; none where no replica
  /// does such a thing.
  virtual std::optional<std::uint64_t> round_trips() const { return std::nullopt; }

  /// Scans over all chains that are consumed, and in total when the stop rule tells.
  virtual std::uint64_t scans_consumed() const = 0;
  virtual std::optional<std::uint64_t> scans_total() const = 0;

  /// What was learnt from the scans consumed so far; nothing if the method learns nothing.
  virtual Report report() const { return {}; }
  /// False: report() is empty, and all scans are draws, whatever is consumed.
  virtual bool learns() const { return true; }
};

inline std::optional<Block> Plan::next_block(const BlockLimits& limits) {
  std::optional<Unit> unit = next_unit(limits.unit_scans_max);
  if (!unit) return std::nullopt;
  return Block{.members = {*std::move(unit)}, .ladder = {}};
}

}  // namespace sleight::plan
