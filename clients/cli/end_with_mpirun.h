// Ends a rank whose mpirun is killed.
#pragma once

namespace sleight::cli {

/// From now on, the process ends when its parent ends in any way. It then also deletes the files
/// behind Open MPI's shared memory, which would remain because the process that cleans up has
/// ended. REQUIRES: call it in a rank before MPI starts.
void end_with_mpirun();

}  // namespace sleight::cli
