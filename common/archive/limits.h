// Maximum sizes of archives. Our writer stays far below these limits; larger files are damaged or
// hostile. The HDF5 reader (hdf5/reader.h) checks the limits in files. The client of a reader
// process (remote/remote_source.h) checks them again in its answers.
#pragma once

#include <cstdint>

namespace sleight::archive {

/// Groups and datasets of a file. A world has some tens of variables in four groups.
inline constexpr std::uint64_t k_objects_max = 2048;
/// Attributes of an object, including those of dimension scales.
inline constexpr std::uint64_t k_attributes_max = 64;
inline constexpr std::uint64_t k_attribute_bytes_max = 64 * 1024;
/// A scalar text, such as the request.
inline constexpr std::uint64_t k_text_bytes_max = 16 * 1024 * 1024;
/// Uncompressed values of a dataset: 10^9 scans of four chains with 250 proposal kinds.
inline constexpr std::uint64_t k_dataset_bytes_max = std::uint64_t{1} << 42;

}  // namespace sleight::archive
