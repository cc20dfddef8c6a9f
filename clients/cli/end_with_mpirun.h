// Ends a rank whose mpirun is killed.
#pragma once

namespace sleight::cli {

/// From now on, the process ends when its parent ends in any way. The process then also deletes the
/// files behind Open MPI's shared memory, which nothing else would delete. REQUIRES: call it in a
/// rank before MPI starts.
void end_with_mpirun();

}  // namespace sleight::cli
