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
// What (c) compares is asked of the reader once for each animation, as it may take a simulation:
// that of kept ones is held while their lineage may get another, up to k_likeness_bytes_max in all.
// What does not fit is asked for again at each comparison.
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

/// Likenesses of kept animations that are held: 1,000 of five dice take some 20 MB.
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
  /// A kept animation of a lineage that may get more.
  struct Compared {
    std::size_t index = 0;              ///< into of_chain_
    std::vector<double> likeness = {};  ///< empty where it isn't held, or nothing was compared yet
  };

  bool plays_out(const plan::ScanRecord& record);
  bool is_distinct(std::vector<Compared>& kept, std::span<const double> likeness);
  /// If there is room.
  void hold(Compared& compared, std::vector<double> likeness);
  void forget(std::vector<Compared>& kept);
  void close_chain();

  const StateReader& reader_;
  DistinctOptions options_;
  base::ChainId chain_{};
  std::vector<KeptAnimation> merged_;    ///< of the chains before, in logical order
  std::vector<KeptAnimation> of_chain_;  ///< of the chain at hand
  /// Of a lineage that is full, none. Used for look-up alone.
  std::map<std::uint64_t, std::vector<Compared>> by_lineage_;
  std::set<std::uint64_t> full_lineages_;
  std::size_t likeness_bytes_ = 0;  ///< held
  std::uint64_t failed_ = 0;
};

}  // namespace sleight::archive
