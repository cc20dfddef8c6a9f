// Drives any plan in any order. The worker returns made-up numbers. Records units and results.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "common/base/clock.h"
#include "common/plan/plan.h"
#include "common/random/stream.h"
#include "tests/tempering/slow_ladder.h"
#include "worker/sampling/block_runner.h"
#include "worker/sampling/stop_rule.h"

namespace sleight::sampling {

/// Random choices of a test, from a printed seed.
class Dice {
 public:
  Dice(std::uint64_t seed, std::uint64_t index);
  std::uint64_t below(std::uint64_t count);
  bool once_in(std::uint64_t count) { return below(count) == 0; }

 private:
  random::Stream stream_;
};

/// Runs HashedWorker scan by scan, so the cuts of units don't affect results. Accepts a third of
/// all excursions. Results also depend on the excursions' temperatures.
class ScanByScan final : public plan::UnitWorker {
 public:
  explicit ScanByScan(const HashedWorker::Options& options) : hashed_(options) {}
  plan::UnitResult run(const plan::Unit& unit, base::BytesView state) const override;

 private:
  HashedWorker hashed_;
};

struct Place {
  plan::ReplicaKey replica;
  std::uint64_t scan = 0;
  friend auto operator<=>(const Place&, const Place&) = default;
};

struct ScanRun {
  plan::Unit unit;  ///< as if handed out alone
  plan::ScanRecord record;
  base::Bytes state_after;
  friend bool operator==(const ScanRun&, const ScanRun&) = default;
};
using ScanRuns = std::map<Place, ScanRun>;

/// Returns the nth scan of a unit as a unit of its own.
plan::Unit alone(const plan::Unit& unit, std::uint32_t nth, std::uint64_t lineage);

/// Runs units scan by scan and records the results. So the worker holds the states that it
/// computed.
class RecordingWorker final : public plan::UnitWorker {
 public:
  explicit RecordingWorker(const plan::UnitWorker& worker) : worker_(worker) {}
  plan::UnitResult run(const plan::Unit& unit, base::BytesView state) const override;
  std::optional<plan::UnitResult> run_from_held(const plan::Unit& unit) const override;
  bool holds(const plan::Unit& unit) const override;
  const ScanRun& made(const Place& place) const { return made_.at(place); }

 private:
  const plan::UnitWorker& worker_;
  mutable ScanRuns made_;
};

struct BlockShapes {
  std::uint64_t of_several = 0;  ///< blocks with more than one member
  std::uint64_t staggered = 0;   ///< blocks whose members began at different scans
  std::uint64_t whole = 0;       ///< blocks of whole ladders that reached the round's end
  std::uint64_t cut = 0;         ///< blocks ended by the limit
  std::uint64_t went_on = 0;     ///< members with more than one scan
  std::uint64_t swapped = 0;     ///< members' scans at another level than the previous scan
  std::uint64_t left = 0;        ///< members that stopped because their partner is outside
  std::uint64_t annealing = 0;   ///< units that anneal
  std::uint64_t held = 0;        ///< states that weren't given but held
  std::uint64_t lacking = 0;     ///< blocks that couldn't run because a state was missing
};

class AnySession {
 public:
  AnySession(plan::Plan& plan, const plan::UnitWorker& worker)
      : plan_(plan), workers_{RecordingWorker(worker), RecordingWorker(worker)} {}

  void run_serially();
  /// Runs units of random lengths that complete in random order, for at most `steps` steps.
  void run_randomly(Dice& dice, std::uint64_t steps = UINT64_MAX);
  /// Runs blocks of random sizes on two workers. Some states are given to the workers, and some are
  /// held by the workers. Consumes the members' results separately, in random order.
  void run_in_blocks(Dice& dice, BlockShapes& shapes, std::uint64_t steps = UINT64_MAX);
  /// A function that runs blocks in place of BlockRunner::run, to test faulty runners.
  using RunBlock = std::function<std::vector<plan::UnitResult>(
      const BlockRunner&, const plan::Block&, std::span<const plan::GivenState>)>;
  void run_blocks_by(RunBlock run) { run_block_ = std::move(run); }
  void complete_all(Dice& dice);
  /// Consumes whole replicas in random batches. Replicas are in random order or in stored order.
  void replay(const ScanRuns& stored, Dice& dice);

  const ScanRuns& runs() const { return runs_; }

 private:
  struct Running {
    plan::UnitResult result;
    std::vector<ScanRun> scans;
  };
  void run(Dice& dice, std::uint64_t steps, const std::function<bool()>& hand_out);
  bool hand_out(std::uint32_t scans_max);
  bool hand_out_block(Dice& dice, BlockShapes& shapes);
  void expect_next(const plan::Unit& unit) const;
  base::Bytes state_before(const plan::Unit& unit) const;
  void takes(const RecordingWorker& worker, plan::UnitResult result);
  void complete(std::size_t which);

  plan::Plan& plan_;
  std::array<RecordingWorker, 2> workers_;
  base::ManualClock clock_;
  ScanRuns runs_;
  std::map<plan::ReplicaKey, std::uint64_t> next_scan_;
  std::vector<Running> running_;
  RunBlock run_block_ = &BlockRunner::run;
};

/// Returns the scan at which a run must stop. Applies the plain rules to the results of a longer
/// run. The first `before` scans of each chain belong to no round.
std::uint64_t scans_at_stop(const StopRule& stop, std::uint64_t round_scans, std::uint64_t before,
                            const ScanRuns& runs);

/// Queries a plan every `step` scans. Expects that the plan reports exactly the counted solutions
/// of its DrawParts, and that log_p is log_p_of(chain, scan). A part's solutions appear at the
/// part's end.
void expect_told_as_counted(
    const plan::Plan& plan, std::uint64_t step,
    const std::function<double(std::uint32_t chain, std::uint64_t scan)>& log_p_of);

/// Compares bit for bit, NaN included.
void expect_equal(const plan::Report& a, const plan::Report& b);

}  // namespace sleight::sampling
