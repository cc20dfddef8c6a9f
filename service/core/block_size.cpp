#include "service/core/block_size.h"

#include <cmath>

namespace sleight::core {

plan::BlockLimits BlockSize::limits(const Threads& threads, std::uint64_t scans_max) const {
  const double cost_s = scan_cost_s_ > 0 ? scan_cost_s_ : start_cost_s_;
  if (cost_s == 0) return {.unit_scans_max = 1, .block_scans_max = 1};
  const double kept_up_s =
      options_.handling_s * static_cast<double>(threads.at_work) / options_.handling_share;
  const double target_s = std::clamp(kept_up_s, options_.target_s, options_.target_s_max);
  const double least_s = std::max(options_.least_s, std::min(kept_up_s, options_.target_s_max));
  const double wanted_s = std::max(least_s, slack_ * target_s);
  const double most = std::min<double>(options_.scans_max, scans_max_);
  const double scans = std::clamp(wanted_s / cost_s, 1.0, most);
  const double of_one =
      std::clamp(std::max(static_cast<double>(scans_max), least_s / cost_s), 1.0, scans);
  // Limit the threads: the coordinator can supply only `fed` threads with blocks of a split ladder.
  const double fed = std::max(1.0, k_part_scans * cost_s / options_.handling_s);
  const double whole = std::min<double>(options_.scans_max, options_.whole_s_max / cost_s);
  return {.unit_scans_max = static_cast<std::uint32_t>(of_one),
          .block_scans_max = static_cast<std::uint32_t>(scans),
          .threads = static_cast<std::uint64_t>(std::min(static_cast<double>(threads.all), fed)),
          .whole_levels_max = static_cast<std::uint32_t>(whole)};
}

void BlockSize::measured(std::uint64_t scans, std::uint64_t moving, double cost_s) {
  if (!std::isfinite(cost_s) || cost_s < 0) return;
  const double cost = std::max(cost_s / static_cast<double>(moving > 0 ? moving : scans), 1e-9);
  if (moving == 0) {
    start_cost_s_ = cost;
  } else {
    scan_cost_s_ = scan_cost_s_ == 0 ? cost : 0.8 * scan_cost_s_ + 0.2 * cost;
  }
  scans_max_ = std::max(scans_max_, k_growth * static_cast<double>(scans));
}

}  // namespace sleight::core
