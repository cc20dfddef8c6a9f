// Runs a batch job's rank other than 0. The rank computes the blocks that rank 0 assigns, until
// rank 0 sends a stop.
#pragma once

#include "common/plan/block.h"
#include "common/schema/messages.h"

namespace sleight::run {

/// Sends hello, then serves. While idle, polls for messages at intervals that grow from 20 us to 2
/// ms. Polling uses under 2% of a core. Doesn't catch the worker's exceptions; the caller reports
/// them to rank 0. REQUIRES: initialised MPI; a rank other than 0.
void serve(const plan::BlockWorker& worker, const schema::Hello& hello);

/// Reports to rank 0 that this rank can't serve, with the reason.
void refuse(const std::string& reason);

}  // namespace sleight::run
