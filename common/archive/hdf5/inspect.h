// Walks an untrusted HDF5 file and returns its contents, or refuses it (reader.h).
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/archive/hdf5/handle.h"
#include "common/archive/model.h"

namespace sleight::archive::hdf5 {

struct StoredDataset {
  Handle id;
  ElementType type = ElementType::f64;
  std::vector<std::uint64_t> dims;  ///< without the width of a text array
  std::uint64_t text_bytes = 0;
};

struct Contents {
  std::vector<Group> groups;
  std::map<std::string, StoredDataset> datasets;  ///< by path
};

/// REQUIRES: `file` is open; `file_bytes` is its length. Throws if the file is refused.
Contents inspect(const Api& api, hid_t file, std::uint64_t file_bytes);

}  // namespace sleight::archive::hdf5
