#include "worker/sampling/chain_part.h"

#include <algorithm>

namespace sleight::sampling {

void Solutions::add(std::uint64_t scan, const plan::ScanRecord& record) {
  if (!record.satisfied || record.inverse_temperature != 1) return;
  const auto known = std::ranges::lower_bound(lineages_, record.lineage);
  if (known != lineages_.end() && *known == record.lineage) return;
  lineages_.insert(known, record.lineage);
  scans_.push_back(scan);
}

}  // namespace sleight::sampling
