// Ends a rank whose mpirun is killed.
#pragma once

namespace sleight::cli {

/// From now on, if the parent ends in any way, this process also ends. This process then also
/// deletes the files of Open MPI's shared memory, because nothing else would delete these files.
/// REQUIRES: call it in a rank before MPI starts.
void end_with_mpirun();

}  // namespace sleight::cli
