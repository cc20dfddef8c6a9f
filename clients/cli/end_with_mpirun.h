// What becomes of a rank whose mpirun is killed.
#pragma once

namespace sleight::cli {

/// From here on this process ends at once when its parent does, however that ends, and takes Open
/// MPI's shared memory with it: the files that back it would stay, since the one that clears up is
/// gone. For a rank, before MPI is started.
void end_with_mpirun();

}  // namespace sleight::cli
