// Reports results of ladders as tables of an archive's group /tempering. Tables have space for the
// largest round and ladder; NaN fills the rest.
#pragma once

#include <cstdint>
#include <span>

#include "common/plan/report.h"
#include "worker/sampling/ladder_run.h"

namespace sleight::sampling {

/// Omits rounds before scan `burnt_in_at`, because their states may descend from a search.
plan::Report report_of(std::span<const LadderRun* const> ladders, std::uint64_t burnt_in_at = 0);

}  // namespace sleight::sampling
