// The run store of a simulated coordinator: results are put, and become durable in groups. A crash
// takes what was not committed; a full disk fails a commit, which ends the coordinator.
//
// What it must be given, and what it must keep, is checked on the way (violation()):
//   1. Of each replica the scans go on from one another, and none comes again.
//   2. What a commit has acknowledged is there when the store is opened next.
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
  /// Where in a commit the coordinator ends.
  enum class Crash { none, before, within, after };

  SimStore(std::uint64_t seed, Mistake mistake)
      : dice_(seed, Dice::Part::store), mistake_(mistake) {}

  /// A new epoch; none while the disk is full. Forgets what was put and not committed.
  std::optional<std::uint64_t> open(double now_s);
  void put(plan::UnitResult result);
  bool has_pending() const { return !pending_.empty(); }
  /// All that was put; false: whoever committed is no more.
  [[nodiscard]] bool commit(double now_s);

  void crash_at_next_commit(Crash crash) { crash_ = crash; }
  void fill_until(double time_s) { full_until_s_ = std::max(full_until_s_, time_s); }

  const Ledger& durable() const { return durable_; }
  const std::string& violation() const { return violation_; }

 private:
  /// Of what was put, the first so many results.
  void make_durable(std::size_t results, bool is_acknowledged);
  void check_acknowledged();
  void note(std::string violation);

  Dice dice_;
  Mistake mistake_;
  Ledger durable_;
  std::map<plan::ReplicaKey, std::uint64_t> acknowledged_;  ///< the scan after the last
  std::map<plan::ReplicaKey, std::uint64_t> put_up_to_;     ///< likewise of what was put
  std::vector<plan::UnitResult> pending_;
  std::uint64_t epoch_ = 0;
  Crash crash_ = Crash::none;
  double full_until_s_ = 0;
  std::string violation_;  ///< the first
};

}  // namespace sleight::cluster
