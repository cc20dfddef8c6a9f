// Counts an archive's solutions, lineages and proposals. Reads the scans in batches.
#pragma once

#include <cstdint>
#include <vector>

#include "clients/analysis/diagnosis.h"
#include "clients/analysis/tempering.h"
#include "common/archive/model.h"

namespace sleight::analysis {

/// Maximum lineages per chain that are distinguished. If a chain has more lineages, the count is a
/// lower bound.
inline constexpr std::uint64_t k_lineages_max = std::uint64_t{1} << 22;

struct RunCounts {
  std::uint64_t satisfied = 0;         ///< scans
  std::uint64_t satisfied_judged = 0;  ///< among the judged scans
  std::uint64_t solutions = 0;         ///< distinct (chain, lineage) of satisfied scans
  bool solutions_more = false;         ///< more exist, because k_lineages_max was reached
};

/// Throws base::Error(bad_archive) if a dataset has an unexpected shape.
RunCounts run_counts(const archive::Source& source, const Round& judged);

/// Counts proposals by kind over the judged scans of all chains. Throws base::Error(bad_archive) if
/// a dataset has an unexpected shape.
std::vector<KindReport> kind_counts(const archive::Source& source, const Round& judged);

}  // namespace sleight::analysis
