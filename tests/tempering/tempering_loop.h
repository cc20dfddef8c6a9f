// Parallel tempering as one loop. The loop defines the method on one screen (tempering_loop.cpp).
//
// Runs use LadderRun (worker/sampling/ladder_run.h) and blocks (block_runner.h there) instead.
// Tests compare both with this loop's results, bit for bit. The loop implements its own swap.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "common/plan/unit.h"
#include "worker/sampling/ladder_round.h"

namespace sleight::sampling {

/// A scan of one replica. The scan continues from the replica's previous scan. A scan at inverse
/// temperature 0 is a new prior draw. A replica's first scan, in any round, is a prior draw too.
struct LoopScan {
  std::uint32_t replica = 0;
  std::uint64_t scan = 0;
  double inverse_temperature = 0;
  std::span<const double> proposal_scales;
};
using MakeScan = std::function<plan::ScanRecord(const LoopScan&)>;

/// Runs `scans` scans of one ladder, including annealing. Returns the ladder's rounds. The current
/// round is last, and may have no scans yet. Round trips and restarts are not counted.
std::vector<RoundReport> tempering_loop(const LadderOptions& options, std::uint64_t scans,
                                        const MakeScan& make_scan);

}  // namespace sleight::sampling
