// Selects the satisfying animations that an archive keeps: those that viewers can tell apart.
//
// By definition, all scans of the run are visited in logical order, by (scan, chain). An animation
// is kept if
//   a. it is satisfied, and
//   b. fewer than keep_per_lineage animations of its (chain, lineage) are kept so far, and
//   c. its likeness distance from each of these animations is above min_distance, and
//   d. fewer than keep_max animations are kept in all.
//
// The implementation reads a run chain by chain, with the same result. Conditions (b) and (c)
// depend only on the animation's own chain and lineage, whose scans have the same order in both
// readings. So without (d) both readings keep the same set. Condition (d) only truncates this set
// to its first keep_max members in logical order, and the removed members don't affect earlier
// ones. So the implementation selects chain by chain, merges by (scan, chain) and truncates. For
// the same reason, only the first keep_max selected animations of a chain can be kept. So the
// memory is at most 2 keep_max records for runs of any length.
//
// The reader computes each animation's likeness for (c) once, because this may take a simulation. A
// kept animation's likeness is stored while its lineage may get another animation. All stored
// likenesses together have at most k_likeness_bytes_max bytes. Other likenesses are recomputed for
// each comparison.
//
// Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <vector>

#include "common/archive/world_layout.h"
#include "common/plan/unit.h"

namespace sleight::archive {

/// Limit for stored likenesses of kept animations: 1,000 likenesses of five dice take some 20 MB.
inline constexpr std::size_t k_likeness_bytes_max = std::size_t{512} << 20;

struct DistinctOptions {
  std::uint64_t keep_max = 0;
  std::uint64_t keep_per_lineage = 0;
  double min_distance = 0;  ///< in the unit of the world's likeness distance
  std::size_t likeness_bytes_max = k_likeness_bytes_max;
};

struct KeptAnimation {
  base::ScanIndex scan;
  base::ChainId chain;
  plan::ScanRecord record;
};

class DistinctSelector {
 public:
  DistinctSelector(const StateReader& reader, const DistinctOptions& options)
      : reader_(reader), options_(options) {}

  /// REQUIRES: chains ascend, scans ascend within a chain, and a satisfied record has a state.
  void offer(base::ChainId chain, base::ScanIndex scan, const plan::ScanRecord& record);

  /// Returns the kept animations in logical order. REQUIRES: first call.
  std::vector<KeptAnimation> finish();
  /// Number of animations that aren't kept because the simulator couldn't complete their motion.
  std::uint64_t failed() const { return failed_; }

 private:
  /// A kept animation whose lineage may get further animations.
  struct Compared {
    std::size_t index = 0;              ///< index into of_chain_
    std::vector<double> likeness = {};  ///< empty: not stored or not yet compared
  };

  bool plays_out(const plan::ScanRecord& record);
  bool is_distinct(std::vector<Compared>& kept, std::span<const double> likeness);
  /// Stores the likeness if the limit allows.
  void hold(Compared& compared, std::vector<double> likeness);
  void forget(std::vector<Compared>& kept);
  void close_chain();

  const StateReader& reader_;
  DistinctOptions options_;
  base::ChainId chain_{};
  std::vector<KeptAnimation> merged_;    ///< of the previous chains, in logical order
  std::vector<KeptAnimation> of_chain_;  ///< of the current chain
  /// Kept animations by lineage. Empty: the lineage is full. Used only for look-up.
  std::map<std::uint64_t, std::vector<Compared>> by_lineage_;
  std::set<std::uint64_t> full_lineages_;
  std::size_t likeness_bytes_ = 0;
  std::uint64_t failed_ = 0;
};

}  // namespace sleight::archive
