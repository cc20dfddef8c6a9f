// What ladders learnt, as the tables of an archive's group /tempering. Sizes differ between rounds
// and ladders: a table's dimensions are those of the largest, and the rest is NaN.
#pragma once

#include <span>

#include "common/plan/report.h"
#include "worker/sampling/ladder_run.h"

namespace sleight::sampling {

plan::Report report_of(std::span<const LadderRun* const> ladders);

}  // namespace sleight::sampling
