// Counts over all scans of an archive, read in batches: what satisfied, by how many lineages, and
// what became of the proposals.
#pragma once

#include <cstdint>
#include <vector>

#include "clients/analysis/diagnosis.h"
#include "clients/analysis/tempering.h"
#include "common/archive/model.h"

namespace sleight::analysis {

/// Lineages of one chain that are told apart; a chain with more has more than can be counted here.
inline constexpr std::uint64_t k_lineages_max = std::uint64_t{1} << 22;

struct RunCounts {
  std::uint64_t satisfied = 0;         ///< scans
  std::uint64_t satisfied_judged = 0;  ///< of the judged ones
  std::uint64_t solutions = 0;         ///< distinct (chain, lineage) of satisfied scans
  bool solutions_more = false;         ///< there are more, k_lineages_max being reached
};

/// Throws base::Error(bad_archive) when a dataset has another shape.
RunCounts run_counts(const archive::Source& source, const Round& judged);

/// Of the judged scans of all chains, by kind. Throws base::Error(bad_archive) likewise.
std::vector<KindReport> kind_counts(const archive::Source& source, const Round& judged);

}  // namespace sleight::analysis
