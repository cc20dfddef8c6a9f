// Archives from HDF5 files that may be damaged or hostile.
//
// Before any value is read, open_file walks the whole file and refuses whatever our writer would
// not have written: soft and external links, objects with several names (and so cycles), groups
// below groups, committed and variable-length types, virtual datasets, external storage, filters
// other than shuffle, deflate and fletcher32, dimensions without coordinate, sizes beyond the
// limits below or beyond what the file's bytes can hold. Variable-length data is never read: the
// names of dimensions come from the scales' REFERENCE_LIST, not from DIMENSION_LIST.
//
// Each refusal is a base::Error with ExitCode::bad_archive that names the file, the object and the
// reason. Damage in compressed values shows only when they are read, and damage in plain ones only
// by the digest (verify.h). HDF5 itself may crash or hang on a damaged file before any check of
// ours can run: programs call this inside guarded (guarded.h).
//
// One thread at a time in the process (handle.h).
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "common/archive/model.h"

namespace sleight::archive::hdf5 {

/// Groups and datasets of a file. A world has some tens of variables in four groups.
inline constexpr std::uint64_t k_objects_max = 2048;
/// Attributes of one object, those of dimension scales included.
inline constexpr std::uint64_t k_attributes_max = 64;
inline constexpr std::uint64_t k_attribute_bytes_max = 64 * 1024;
/// A scalar text: the request.
inline constexpr std::uint64_t k_text_bytes_max = 16 * 1024 * 1024;
/// Values of one dataset, uncompressed: 10^9 scans of four chains with 250 proposal kinds.
inline constexpr std::uint64_t k_dataset_bytes_max = std::uint64_t{1} << 42;
/// One chunk, uncompressed: read at once by HDF5.
inline constexpr std::uint64_t k_chunk_bytes_max = 64 * 1024 * 1024;
/// Deflate can't do better than this, so no dataset is larger than its storage times this.
inline constexpr std::uint64_t k_deflate_ratio_max = 1032;

/// Opens an archive for reading. A file that does not exist or can't be read is an environment
/// error (ExitCode::environment); everything else as above.
std::unique_ptr<Source> open_file(const std::string& path);

}  // namespace sleight::archive::hdf5
