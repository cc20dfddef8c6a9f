// How large blocks are, from what scans have cost: long enough that handing them out costs little,
// short enough that all workers have some and that a stop is answered soon. Changes no result.
// Not thread-safe.
#pragma once

#include <algorithm>
#include <cstdint>

#include "common/plan/block.h"

namespace sleight::core {

struct BlockSizeOptions {
  /// A block should take about this long...
  double target_s = 0.050;
  /// ...or so much that the coordinator keeps up with the threads at work: what one block costs it,
  /// results stored included, times this many threads' blocks, at this share of its time.
  double handling_s = 50e-6;
  double handling_share = 0.5;
  /// Never longer than this by the coordinator's account, nor, when workers wait for work, longer
  /// than this much.
  double target_s_max = 1;
  double least_s = 0.001;
  /// A ladder whose levels' scans take together no longer than this stays whole where there are
  /// ladders enough.
  double whole_s_max = 0.25;
  std::uint32_t scans_max = 8192;  ///< of a block: bounds a result's memory
};

class BlockSize {
 public:
  explicit BlockSize(const BlockSizeOptions& options) : options_(options) {}

  /// Threads that there are, and those of them that have work: fewer where a plan has no more.
  struct Threads {
    std::uint64_t all = 1;
    std::uint64_t at_work = 1;
  };
  /// What a block may have. `scans_max`: of one replica, unless the coordinator could not keep up
  /// with blocks so short.
  plan::BlockLimits limits(const Threads& threads, std::uint64_t scans_max) const;
  /// A block with as many scans took so long. `moving`: those that made proposals. A start costs
  /// next to nothing, or as much as a scan where it is an island: it counts as long as nothing else
  /// is known. A time that is none (it comes from another rank) is left out.
  void measured(std::uint64_t scans, std::uint64_t moving, double cost_s);
  /// A thread found no work although a plan goes on; or it found some.
  void starved() { slack_ = std::max(slack_ * k_narrowing, slack_min()); }
  void fed() { slack_ = std::min(slack_ * k_widening, 1.0); }

  /// Of a block as they are now; 0 before anything is measured.
  double expected_s(std::uint64_t scans) const { return scan_cost_s_ * static_cast<double>(scans); }

 private:
  static constexpr double k_narrowing = 0.7;
  static constexpr double k_widening = 1.01;
  static constexpr double k_growth = 8;
  /// What least_s leaves of target_s: less would not show, and take long to come back from.
  double slack_min() const { return std::min(options_.least_s / options_.target_s, 1.0); }
  BlockSizeOptions options_;
  /// Scans that the blocks of a split ladder have on average, however many they may have.
  static constexpr double k_part_scans = 4;
  double scan_cost_s_ = 0;
  double start_cost_s_ = 0;
  double scans_max_ = 1;  ///< at most k_growth times as many as some block had
  double slack_ = 1;      ///< in [slack_min, 1]: smaller where workers waited
};

}  // namespace sleight::core
