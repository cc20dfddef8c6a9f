// Chooses the size of blocks from the measured cost of scans. Blocks are so long that handing them
// out costs little. Blocks are so short that every worker gets some and a stop is quick. Changes no
// result. Not thread-safe.
#pragma once

#include <algorithm>
#include <cstdint>

#include "common/plan/block.h"

namespace sleight::core {

struct BlockSizeOptions {
  /// Target duration of a block.
  double target_s = 0.050;
  /// The coordinator spends handling_s on each block, which includes storing the results. All
  /// blocks together may take at most handling_share of the coordinator's time. So if many threads
  /// are busy, blocks may be longer than target_s.
  double handling_s = 50e-6;
  double handling_share = 0.5;
  /// A block takes at most target_s_max. When workers wait, a block takes at least least_s.
  double target_s_max = 1;
  double least_s = 0.001;
  /// If there are enough ladders and a scan of all levels takes at most this long, a ladder isn't
  /// split.
  double whole_s_max = 0.25;
  std::uint32_t scans_max = 8192;  ///< Maximum scans of a block, which limits a result's memory.
};

class BlockSize {
 public:
  explicit BlockSize(const BlockSizeOptions& options) : options_(options) {}

  /// Number of threads; number of threads that have work.
  struct Threads {
    std::uint64_t all = 1;
    std::uint64_t at_work = 1;
  };
  /// Limits of the next block. `scans_max`: maximum scans of one replica. If the coordinator can't
  /// keep up otherwise, a block may exceed this maximum.
  plan::BlockLimits limits(const Threads& threads, std::uint64_t scans_max) const;
  /// Reports a completed block. `moving`: how many of the block's scans made proposals. Starts
  /// count only until a scan's cost is known. If a start is an island, it costs as much as a scan,
  /// otherwise almost nothing. Ignores invalid times, which other ranks may send.
  void measured(std::uint64_t scans, std::uint64_t moving, double cost_s);
  /// Report that a thread found no work although the plan continues (starved), or found work (fed).
  void starved() { slack_ = std::max(slack_ * k_narrowing, slack_min()); }
  void fed() { slack_ = std::min(slack_ * k_widening, 1.0); }

  /// Expected duration of a block at the current cost; 0 before any measurement.
  double expected_s(std::uint64_t scans) const { return scan_cost_s_ * static_cast<double>(scans); }

 private:
  static constexpr double k_narrowing = 0.7;
  static constexpr double k_widening = 1.01;
  static constexpr double k_growth = 8;
  /// Minimum slack. A smaller slack would have no effect, and would grow again only slowly.
  double slack_min() const { return std::min(options_.least_s / options_.target_s, 1.0); }
  BlockSizeOptions options_;
  /// Mean number of scans in a split ladder's blocks. The mean doesn't depend on the limit.
  static constexpr double k_part_scans = 4;
  double scan_cost_s_ = 0;
  double start_cost_s_ = 0;
  double scans_max_ = 1;  ///< At most k_growth times the scans of the largest block so far.
  double slack_ = 1;      ///< In [slack_min, 1]; decreases when workers wait.
};

}  // namespace sleight::core
