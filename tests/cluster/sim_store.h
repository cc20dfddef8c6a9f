// The run store of a simulated coordinator. Results become durable in groups. A crash loses
// uncommitted results. A full disk fails a commit, which ends the coordinator.
//
// The store checks two invariants (violation()):
//   1. Each replica's scans are consecutive, and none is repeated.
//   2. A store that is opened again has all acknowledged commits.
// Not thread-safe.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/cluster/dice.h"
#include "tests/cluster/ledger.h"
#include "tests/cluster/mistakes.h"

namespace sleight::cluster {

class SimStore {
 public:
  /// The point in a commit at which the coordinator dies.
  enum class Crash { none, before, within, after };

  SimStore(std::uint64_t seed, Mistake mistake)
      : dice_(seed, Dice::Part::store), mistake_(mistake) {}

  /// Opens a new epoch and drops uncommitted results. None: the disk is full.
  std::optional<std::uint64_t> open(double now_s);
  void put(plan::UnitResult result);
  bool has_pending() const { return !pending_.empty(); }
  /// Commits everything that was put. False: the coordinator has died.
  [[nodiscard]] bool commit(double now_s);

  void crash_at_next_commit(Crash crash) { crash_ = crash; }
  void fill_until(double time_s) { full_until_s_ = std::max(full_until_s_, time_s); }

  const Ledger& durable() const { return durable_; }
  const std::string& violation() const { return violation_; }

 private:
  /// Makes the first `results` results durable.
  void make_durable(std::size_t results, bool is_acknowledged);
  void check_acknowledged();
  void note(std::string violation);

  Dice dice_;
  Mistake mistake_;
  Ledger durable_;
  std::map<plan::ReplicaKey, std::uint64_t>
      acknowledged_;                                     ///< scan after the last acknowledged one
  std::map<plan::ReplicaKey, std::uint64_t> put_up_to_;  ///< scan after the last one that was put
  std::vector<plan::UnitResult> pending_;
  std::uint64_t epoch_ = 0;
  Crash crash_ = Crash::none;
  double full_until_s_ = 0;
  std::string violation_;  ///< the first
};

}  // namespace sleight::cluster
