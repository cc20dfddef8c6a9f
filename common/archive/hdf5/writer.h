// Writes archives as HDF5 files that xarray (netcdf4, h5netcdf) and h5py open directly.
//
// Invariants:
//  1. A reader never sees an incomplete file. The archive is written to `<path>.tmp.<process id>`,
//     closed, synced and renamed, and the folder is synced. A failure before the rename leaves the
//     file at `path` unchanged and removes the temporary file. A killed process leaves its
//     temporary file behind, which may be removed at any time.
//  2. Equal content gives equal bytes. The file contains no times, the creation order and the
//     batches (columns.h) are fixed, and a chunk's shape depends only on its dataset's shape.
//  3. Dimensions are HDF5 dimension scales in netCDF-4's form. Text arrays are arrays of single
//     characters, because netCDF-C 4.9.0 crashes on arrays of fixed-length strings.
//
// Thread safety: only one thread of the process may use this folder at a time (handle.h).
#pragma once

#include <functional>
#include <string>

#include "common/archive/model.h"
#include "common/base/file_system.h"

namespace sleight::archive::hdf5 {

/// Writes the archive that `fill` produces, and returns the archive's digest. write_digested checks
/// the archive. If writing fails, throws base::Error with the file's name. Passes on exceptions of
/// `fill`.
std::string write_file(const std::string& path, base::FileSystem& file_system,
                       const std::function<void(Sink&)>& fill);

}  // namespace sleight::archive::hdf5
