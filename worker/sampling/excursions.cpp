#include "worker/sampling/excursions.h"

#include <algorithm>

#include "common/base/check.h"
#include "worker/sampling/ladder.h"

namespace sleight::sampling {

Excursions::Excursions(const BurnIn& burn_in, std::uint32_t steps_per_level)
    : burn_in_(burn_in),
      below_(finer(burn_in.next_ladder, steps_per_level)),
      scan_(burn_in.scans),
      lineage_(burn_in.lineage) {
  // Order the inverse temperatures from the highest below 1 down to the lowest.
  below_.pop_back();
  std::ranges::reverse(below_);
}

std::optional<plan::Unit> Excursions::next_unit(std::uint64_t horizon, std::uint32_t scans_max) {
  if (handed_out_ || scan_ >= horizon) return std::nullopt;
  handed_out_ = true;
  return plan::Unit{
      .replica = {burn_in_.chain, burn_in_.coolest},
      .seed = burn_in_.seed,
      .first_scan = base::ScanIndex{scan_},
      .scans = static_cast<std::uint32_t>(std::min<std::uint64_t>(horizon - scan_, scans_max)),
      .starts = false,
      .lineage = lineage_,
      .inverse_temperatures = {1},
      .proposal_scales = burn_in_.next_scales.back(),
      .excursion = below_};
}

void Excursions::consume(base::ReplicaId replica, std::uint64_t first_scan,
                         std::span<const plan::ScanRecord> records) {
  CHECK_EQ(replica.value, burn_in_.coolest.value);
  CHECK_EQ(first_scan, scan_);
  handed_out_ = false;
  for (const plan::ScanRecord& record : records) {
    if (record.lineage != lineage_) ++accepted_;
    lineage_ = record.lineage;
    solutions_.add(scan_++, record);
  }
}

std::vector<ChainPart::Row> Excursions::rows() const {
  const auto made = static_cast<double>(draws());
  return {{"excursion_inverse_temperature",
           "inverse temperatures of a tempered transition, in descending order", "excursion_level",
           below_},
          {"excursion_acceptance",
           "fraction of tempered transitions that were accepted",
           "",
           {static_cast<double>(accepted_) / made}}};
}

}  // namespace sleight::sampling
