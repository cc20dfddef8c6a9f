// What ladders learnt, as the tables of an archive's group /tempering. Sizes differ between rounds
// and ladders: a table's dimensions are those of the largest, and the rest is NaN.
#pragma once

#include <cstdint>
#include <span>

#include "common/plan/report.h"
#include "worker/sampling/ladder_run.h"

namespace sleight::sampling {

/// Rounds that begin before `burnt_in_at`, in scans, are left out: their states know of a search.
plan::Report report_of(std::span<const LadderRun* const> ladders, std::uint64_t burnt_in_at = 0);

}  // namespace sleight::sampling
