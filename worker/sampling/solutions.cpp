#include "worker/sampling/solutions.h"

#include <algorithm>

namespace sleight::sampling {

void Solutions::add(std::uint64_t scan, const plan::ScanRecord& record) {
  if (!record.satisfied || record.inverse_temperature != 1) return;
  const auto known = std::ranges::lower_bound(lineages_, record.lineage);
  if (known != lineages_.end() && *known == record.lineage) return;
  lineages_.insert(known, record.lineage);
  scans_.insert(std::ranges::upper_bound(scans_, scan), scan);
}

std::uint64_t Solutions::before(std::uint64_t scan) const {
  return static_cast<std::uint64_t>(std::ranges::lower_bound(scans_, scan) - scans_.begin());
}

}  // namespace sleight::sampling
