// Archives as HDF5 files that xarray (netcdf4, h5netcdf) and h5py open as they are.
//
// Invariants:
//  1. A reader never sees a torn file. The archive is written to `<path>.tmp.<process id>` beside
//     its place, closed, synced and renamed, and the folder is synced; a failure before the rename
//     leaves the file at `path` as it was and removes the temporary one. A process that is killed
//     leaves the temporary one behind: it may be removed at any time.
//  2. Equal content gives equal bytes: no times in the file, one fixed order of creation, chunks
//     whose shape follows from the dataset's alone, and fixed batches (columns.h).
//  3. Dimensions are HDF5 dimension scales, in the form that netCDF-4 writes; text arrays are
//     arrays of single characters, since netCDF-C 4.9.0 crashes on arrays of fixed-length strings.
//
// One thread at a time in the process (handle.h).
#pragma once

#include <functional>
#include <string>

#include "common/archive/model.h"
#include "common/base/file_system.h"

namespace sleight::archive::hdf5 {

/// Writes the archive that `fill` gives (see write_digested, which checks it) and returns its
/// digest. Throws base::Error naming the file when it can't be written; also what `fill` throws.
std::string write_file(const std::string& path, base::FileSystem& file_system,
                       const std::function<void(Sink&)>& fill);

}  // namespace sleight::archive::hdf5
