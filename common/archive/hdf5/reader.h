// Reads archives from HDF5 files that may be damaged or hostile.
//
// Before reading any value, open_file walks the whole file and refuses everything that our writer
// doesn't produce. open_file refuses soft and external links, objects with several names (and so
// cycles), nested groups, committed and variable-length types, virtual datasets and external
// storage. open_file also refuses dimensions without coordinate, and filters other than shuffle,
// deflate and fletcher32. The function refuses sizes beyond the file's length, the limits below, or
// the limits of limits.h. Variable-length data is never read: dimensions get their names from the
// scales' REFERENCE_LIST, not from DIMENSION_LIST.
//
// Each refusal is a base::Error with ExitCode::bad_archive that names the file, the object and the
// reason. Damage in compressed values is detected when they are read. Damage in uncompressed values
// is detected only by the digest (verify.h). HDF5 itself may crash or hang on a damaged file before
// any of our checks. So programs open archives through a reader process (archive/remote), which
// calls open_descriptor.
//
// Thread safety: only one thread of the process may use this folder at a time (handle.h).
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "common/archive/model.h"

namespace sleight::archive::hdf5 {

/// Maximum uncompressed size of a chunk, because HDF5 reads a chunk at once.
inline constexpr std::uint64_t k_chunk_bytes_max = 64 * 1024 * 1024;
/// Maximum of a dataset's size divided by its stored size. Deflate can't compress better.
inline constexpr std::uint64_t k_deflate_ratio_max = 1032;

/// Starts the HDF5 library. Without this call, the first open starts the library.
void start();

/// Opens an archive for reading. If the file does not exist or can't be read, throws base::Error
/// with ExitCode::environment. If the file is refused, throws base::Error with
/// ExitCode::bad_archive.
std::unique_ptr<Source> open_file(const std::string& path);

struct OpenFile {
  int descriptor = -1;
  std::uint64_t bytes = 0;
};

/// Like open_file, but takes ownership of a file that is already open. `name`: for messages.
/// REQUIRES: start() was called, and the file is regular. Makes no system calls except for reading
/// the file and allocating memory.
std::unique_ptr<Source> open_descriptor(const std::string& name, const OpenFile& open);

}  // namespace sleight::archive::hdf5
