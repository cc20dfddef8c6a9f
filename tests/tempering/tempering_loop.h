// Parallel tempering as one loop: what the method means, on one screen (tempering_loop.cpp).
//
// Runs go through LadderRun (worker/sampling/ladder_run.h), where replicas run ahead of one another
// and are handed out in blocks to any number of workers (block_runner.h there); tests hold these to
// this loop's results, bit for bit. It has none of their bookkeeping, and the swap stands here in
// full, not taken from swap.h.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "common/plan/unit.h"
#include "worker/sampling/ladder_round.h"

namespace sleight::sampling {

/// A scan of one replica, from its own state after its last scan. At inverse temperature 0 it is a
/// fresh draw from the prior; a replica's first scan is one too, in whichever round it is born.
struct LoopScan {
  std::uint32_t replica = 0;
  std::uint64_t scan = 0;
  double inverse_temperature = 0;
  std::span<const double> proposal_scales;
};
using MakeScan = std::function<plan::ScanRecord(const LoopScan&)>;

/// So many scans of one ladder, those that anneal included: its rounds, the present one last; that
/// one may have no scans yet. Round trips and restarts are not counted.
std::vector<RoundReport> tempering_loop(const LadderOptions& options, std::uint64_t scans,
                                        const MakeScan& make_scan);

}  // namespace sleight::sampling
