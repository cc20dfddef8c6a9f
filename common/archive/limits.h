// Limits of archives. Our writer stays far below these limits, so a file beyond a limit is damaged
// or hostile. The HDF5 reader (hdf5/reader.h) checks the limits in files. The client of a reader
// process (remote/remote_source.h) checks the limits again in answers from that process.
#pragma once

#include <cstdint>

namespace sleight::archive {

/// Maximum number of groups and datasets in a file. A world has some tens of variables in four
/// groups.
inline constexpr std::uint64_t k_objects_max = 2048;
/// Maximum attributes of an object, including the attributes of dimension scales.
inline constexpr std::uint64_t k_attributes_max = 64;
inline constexpr std::uint64_t k_attribute_bytes_max = 64 * 1024;
/// Maximum size of a scalar text, such as the request.
inline constexpr std::uint64_t k_text_bytes_max = 16 * 1024 * 1024;
/// Maximum size of a dataset's uncompressed values. An example is 10^9 scans of four chains if
/// there are 250 proposal kinds.
inline constexpr std::uint64_t k_dataset_bytes_max = std::uint64_t{1} << 42;

}  // namespace sleight::archive
