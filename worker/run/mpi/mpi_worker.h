// A batch job's rank other than 0: computes the blocks that rank 0 assigns until it says stop.
#pragma once

#include "common/plan/block.h"
#include "common/schema/messages.h"

namespace sleight::run {

/// Says hello, then serves. Idle, it looks for messages with a back-off from 20 us to 2 ms, which
/// takes under 2% of a core. What the worker throws comes through; the caller tells rank 0 of it.
/// REQUIRES: MPI is initialised, and this rank is not 0.
void serve(const plan::BlockWorker& worker, const schema::Hello& hello);

/// Tells rank 0 that this rank can't serve, and why.
void refuse(const std::string& reason);

}  // namespace sleight::run
