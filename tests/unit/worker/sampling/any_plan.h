// A plan driven scan by scan by a worker of numbers, in any order: for tests that hold for every
// method. What was handed out and what came of it is kept by place.
#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "common/plan/plan.h"
#include "common/random/stream.h"
#include "tests/unit/worker/sampling/slow_ladder.h"
#include "worker/sampling/stop_rule.h"

namespace sleight::sampling {

/// Random choices of a test, from a seed that is printed.
class Dice {
 public:
  Dice(std::uint64_t seed, std::uint64_t index);
  std::uint64_t below(std::uint64_t count);
  bool once_in(std::uint64_t count) { return below(count) == 0; }

 private:
  random::Stream stream_;
};

/// HashedWorker, scan by scan: how units are cut changes nothing. A third of all excursions are
/// accepted; results hang on their temperatures too.
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
  plan::Unit unit;  ///< as if it had been handed out alone
  plan::ScanRecord record;
  base::Bytes state_after;
  friend bool operator==(const ScanRun&, const ScanRun&) = default;
};
using ScanRuns = std::map<Place, ScanRun>;

class AnySession {
 public:
  AnySession(plan::Plan& plan, const plan::UnitWorker& worker) : plan_(plan), worker_(worker) {}

  /// One unit of one scan after another.
  void run_serially();
  /// Units of random lengths that complete in random order; so many steps at most.
  void run_randomly(Dice& dice, std::uint64_t steps = UINT64_MAX);
  void complete_all(Dice& dice);
  /// Whole replicas in random order (or theirs), in random batches.
  void replay(const ScanRuns& stored, Dice& dice);

  const ScanRuns& runs() const { return runs_; }

 private:
  struct Running {
    plan::UnitResult result;
    std::vector<ScanRun> scans;
  };
  bool hand_out(std::uint32_t scans_max);
  void complete(std::size_t which);

  plan::Plan& plan_;
  const plan::UnitWorker& worker_;
  ScanRuns runs_;
  std::map<plan::ReplicaKey, std::uint64_t> next_scan_;
  std::vector<Running> running_;
};

/// Where a run must stop, by the rules as they are written, from the results of a longer one:
/// `before` scans of each chain belong to no round.
std::uint64_t scans_at_stop(const StopRule& stop, std::uint64_t round_scans, std::uint64_t before,
                            const ScanRuns& runs);

/// Bit for bit, NaN included.
void expect_equal(const plan::Report& a, const plan::Report& b);

}  // namespace sleight::sampling
