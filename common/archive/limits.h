// Sizes up to which an archive is read. What writes one stays far below them; what asks for more is
// damaged or hostile. The HDF5 reader (hdf5/reader.h) checks them in files, and the other end of
// the pipe to a reader process (remote/remote_source.h) checks them again in its answers.
#pragma once

#include <cstdint>

namespace sleight::archive {

/// Groups and datasets of a file. A world has some tens of variables in four groups.
inline constexpr std::uint64_t k_objects_max = 2048;
/// Attributes of one object, those of dimension scales included.
inline constexpr std::uint64_t k_attributes_max = 64;
inline constexpr std::uint64_t k_attribute_bytes_max = 64 * 1024;
/// A scalar text: the request.
inline constexpr std::uint64_t k_text_bytes_max = 16 * 1024 * 1024;
/// Values of one dataset, uncompressed: 10^9 scans of four chains with 250 proposal kinds.
inline constexpr std::uint64_t k_dataset_bytes_max = std::uint64_t{1} << 42;

}  // namespace sleight::archive
