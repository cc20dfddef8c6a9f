// Archives from HDF5 files that may be damaged or hostile.
//
// Before any value is read, open_file walks the whole file and refuses whatever our writer would
// not have written: soft and external links, objects with several names (and so cycles), groups
// below groups, committed and variable-length types, virtual datasets, external storage, filters
// other than shuffle, deflate and fletcher32, dimensions without coordinate, sizes beyond the
// limits below and in limits.h or beyond what the file's bytes can hold. Variable-length data is
// never read: the names of dimensions come from the scales' REFERENCE_LIST, not from
// DIMENSION_LIST.
//
// Each refusal is a base::Error with ExitCode::bad_archive that names the file, the object and the
// reason. Damage in compressed values shows only when they are read, and damage in plain ones only
// by the digest (verify.h). HDF5 itself may crash or hang on a damaged file before any check of
// ours can run: programs open archives by a reader process (archive/remote), which calls this.
//
// One thread at a time in the process (handle.h).
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "common/archive/limits.h"
#include "common/archive/model.h"

namespace sleight::archive::hdf5 {

/// One chunk, uncompressed: read at once by HDF5.
inline constexpr std::uint64_t k_chunk_bytes_max = 64 * 1024 * 1024;
/// Deflate can't do better than this, so no dataset is larger than its storage times this.
inline constexpr std::uint64_t k_deflate_ratio_max = 1032;

/// Starts the HDF5 library, which opening does otherwise.
void start();

/// Opens an archive for reading. A file that does not exist or can't be read is an environment
/// error (ExitCode::environment); everything else as above.
std::unique_ptr<Source> open_file(const std::string& path);

/// A file that is open for reading.
struct OpenFile {
  int descriptor = -1;
  std::uint64_t bytes = 0;  ///< its length
};

/// The same of such a file, which it takes over. `name`: for messages. REQUIRES: start() was
/// called, and it is a regular file. Makes no system call but for memory and to read it.
std::unique_ptr<Source> open_descriptor(const std::string& name, const OpenFile& open);

}  // namespace sleight::archive::hdf5
