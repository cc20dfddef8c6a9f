// Which satisfying animations an archive keeps: those that a viewer would tell apart.
//
// The definition walks all scans of the run in logical order, by (scan, chain). An animation is
// kept when
//   a. it is satisfied, and
//   b. fewer than keep_per_lineage of its (chain, lineage) are kept, and
//   c. its likeness distance from each of these is above min_distance (the first has none), and
//   d. fewer than keep_max are kept in all.
//
// A run is read chain by chain instead. That gives the same animations: (b) and (c) look only at
// the animation's own chain and lineage, whose scans arrive in the same order either way, so
// without (d) both walks keep one and the same set. Condition (d) only cuts this set off after its
// first keep_max members in logical order, and what is cut off influenced nothing before it. Hence:
// select chain by chain, merge by (scan, chain), truncate. For the same reason a chain's first
// keep_max members are all that can survive, which bounds the memory: at most 2 keep_max records
// are held, however long the run.
//
// Not thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "common/archive/world_layout.h"
#include "common/plan/unit.h"

namespace sleight::archive {

struct DistinctOptions {
  std::uint64_t keep_max = 0;
  std::uint64_t keep_per_lineage = 0;
  double min_distance = 0;  ///< in the unit of the world's likeness distance
};

struct KeptAnimation {
  base::ScanIndex scan;
  base::ChainId chain;
  plan::ScanRecord record;
};

class DistinctSelector {
 public:
  /// The reader must outlive the selector.
  DistinctSelector(const StateReader& reader, const DistinctOptions& options)
      : reader_(reader), options_(options) {}

  /// REQUIRES: chains ascend, and scans within a chain; a satisfied record has its state.
  void offer(base::ChainId chain, base::ScanIndex scan, const plan::ScanRecord& record);

  /// The kept animations in logical order. REQUIRES: not called before.
  std::vector<KeptAnimation> finish();
  /// Animations that would have been kept, if the simulator could carry out their whole motion.
  std::uint64_t failed() const { return failed_; }

 private:
  bool plays_out(const plan::ScanRecord& record);
  bool is_distinct(const std::vector<std::size_t>& kept_of_lineage,
                   const plan::ScanRecord& record) const;
  void close_chain();

  const StateReader& reader_;
  DistinctOptions options_;
  base::ChainId chain_{};
  std::vector<KeptAnimation> merged_;    ///< of the chains before, in logical order
  std::vector<KeptAnimation> of_chain_;  ///< of the chain at hand
  /// Indices into of_chain_ by lineage: used for look-up alone.
  std::map<std::uint64_t, std::vector<std::size_t>> by_lineage_;
  std::uint64_t failed_ = 0;
};

}  // namespace sleight::archive
