// A sampling method as a pure plan. A plan decides which units can run, what follows from their
// results, and when the run ends. A plan uses no worker, thread, clock or file. The serial loop,
// the thread pool and the coordinator all execute the same plan, so each method is implemented
// once.
//
// Invariants
//   1. Units of one replica are handed out in scan order, one at a time.
//   2. A plan's decisions are a function of the consumed results. The order in which the results of
//      different replicas arrive doesn't matter. (The order in which ready units are handed out may
//      vary.)
//   3. A fresh plan that consumes an earlier session's stored results reaches that session's state.
// Not thread-safe: one executor drives a plan.
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

/// Consecutive scans that are draws. `counted` has an entry for each chain: its independent
/// solution among these scans, if there is one.
struct DrawPart {
  std::uint64_t first_scan = 0;
  std::uint64_t count = 0;
  std::vector<std::optional<std::uint64_t>> counted{};
};

/// A chain's draws are its records at inverse temperature 1 from first_scan on, ordered by (scan,
/// replica). If `parts` is not empty, only records in parts count.
struct Draws {
  std::uint64_t first_scan = 0;
  std::uint64_t count = 0;  ///< With parts: the total over all parts.
  std::vector<DrawPart> parts{};
};

/// Finds of searches. A find is counted once all earlier starts are done.
struct Finds {
  std::uint64_t found = 0;
  std::uint64_t wanted = 0;  ///< 0: no search.
  bool gave_up = false;      ///< Too many consecutive starts found nothing.
  /// After giving up: what the last starts reached and what to do, in sentences for people.
  std::string gave_up_because{};
  bool is_all = false;  ///< No sampled chains follow the search.
  /// Number of takes.
  std::uint64_t relaxed = 0;
  std::uint64_t relaxed_wanted = 0;  ///< 0: finds are not relaxed.

  bool is_searching() const { return found < wanted && !gave_up; }
};

/// A search's start that found a solution.
struct Find {
  std::uint64_t start = 0;
  double log_p = 0;  ///< log_prior + log_constraint of its record.
};

/// The estimate of P(satisfied) by the free islands so far.
struct Odds {
  bool are_asked = false;
  std::uint64_t islands = 0;  ///< Finished islands; once final, the islands that log_p uses.
  std::uint64_t wanted = 0;   ///< Total number of islands; 0: not known yet.
  std::optional<double> log_p{};
  std::optional<double> log_error{};  ///< Standard error of log_p.
  bool is_final = false;              ///< The odds rule has ended and the error is valid.
  friend bool operator==(const Odds&, const Odds&) = default;
};

/// An independent solution of a chain.
struct Solution {
  base::ChainId chain;
  std::uint64_t scan = 0;
  double log_p = 0;           ///< log_prior + log_constraint of its record.
  std::uint64_t decided = 0;  ///< Number of scans of all chains at which this becomes a solution.
};

/// A completed round of one ladder, or of all chains together (chain 0).
struct EndedRound {
  base::ChainId chain{};
  std::uint64_t round = 0;                     ///< From 1.
  std::uint64_t scans = 0;                     ///< The chain's number of scans at the round's end.
  std::optional<double> swaps{};               ///< Mean swap acceptance, for ladders.
  std::optional<std::uint64_t> round_trips{};  ///< Ended round trips, for ladders.
};

class Plan {
 public:
  virtual ~Plan() = default;

  /// Returns the next unit that can run. Returns nothing if all such units are handed out or done.
  /// The replica that is furthest behind comes first. REQUIRES: scans_max >= 1.
  virtual std::optional<Unit> next_unit(std::uint32_t scans_max) = 0;

  /// Like next_unit, for a block. Plans without swaps return blocks of one unit.
  virtual std::optional<Block> next_block(const BlockLimits& limits);

  /// The state from which a replica starts. Empty: the replica's first unit draws the start.
  /// REQUIRES: the unit with the replica's first scan has been handed out.
  virtual base::BytesView start_state(ReplicaKey /*replica*/) const { return {}; }

  /// Consumes the results of scans [first_scan, first_scan + records.size()) of one replica.
  /// REQUIRES: the records continue that replica's scans, and come from a unit that was handed out.
  /// Before the first next_unit(), they may also come from a run store.
  virtual void consume(ReplicaKey replica, base::ScanIndex first_scan,
                       std::span<const ScanRecord> records) = 0;

  /// Returns whether the stop rule holds. Once it holds, no more units are handed out.
  virtual bool finished() const = 0;

  /// Number of scans that every chain has. An archive written now ends at this scan.
  virtual std::uint64_t scans_common() const = 0;

  /// The draws among these scans.
  virtual Draws draws() const { return {.first_scan = 0, .count = scans_common()}; }

  /// Number of independent solutions so far. solutions_wanted: the number at which the run ends, if
  /// there is one.
  virtual std::uint64_t solutions_found() const { return 0; }
  virtual std::optional<std::uint64_t> solutions_wanted() const { return std::nullopt; }

  /// Solutions with after < decided <= until, ordered by (decided, chain, scan). These solutions
  /// are a function of the results before scan `until`. REQUIRES: until <= scans_common().
  virtual std::vector<Solution> solutions_between(std::uint64_t /*after*/,
                                                  std::uint64_t /*until*/) const {
    return {};
  }

  /// Rounds with after < scans <= until, ordered by (scans, chain). The conditions of
  /// solutions_between hold.
  virtual std::vector<EndedRound> rounds_between(std::uint64_t /*after*/,
                                                 std::uint64_t /*until*/) const {
    return {};
  }

  virtual Finds finds() const { return {}; }

  /// starts_done: number of starts before the first unfinished start. finds_between: the finds of
  /// starts [first, end), in order. REQUIRES: end <= starts_done().
  virtual std::uint64_t starts_done() const { return 0; }
  virtual std::vector<Find> finds_between(std::uint64_t /*first*/, std::uint64_t /*end*/) const {
    return {};
  }

  /// Number of draws from the prior before the first unfinished draw.
  virtual std::uint64_t prior_draws() const { return 0; }
  virtual std::uint64_t prior_draws_wanted() const { return 0; }

  virtual Odds odds() const { return {}; }

  /// Number of trips from the prior to inverse temperature 1 and back. Empty: no trips exist.
  virtual std::optional<std::uint64_t> round_trips() const { return std::nullopt; }

  /// Number of consumed scans in all chains. scans_total: the run's total number of scans, if the
  /// stop rule determines it.
  virtual std::uint64_t scans_consumed() const = 0;
  virtual std::optional<std::uint64_t> scans_total() const = 0;

  /// The method's report on the consumed scans. Empty for methods without one.
  virtual Report report() const { return {}; }
  /// False: report() stays empty and all scans are draws.
  virtual bool learns() const { return true; }
};

inline std::optional<Block> Plan::next_block(const BlockLimits& limits) {
  std::optional<Unit> unit = next_unit(limits.unit_scans_max);
  if (!unit) return std::nullopt;
  return Block{.members = {*std::move(unit)}};
}

}  // namespace sleight::plan
