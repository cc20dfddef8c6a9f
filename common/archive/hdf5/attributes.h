// Reads the attributes of an untrusted HDF5 object (reader.h). Some attributes belong to the
// archive, others to HDF5's dimension scales.
#pragma once

#include <string>
#include <vector>

#include "common/archive/hdf5/handle.h"
#include "common/archive/model.h"

namespace sleight::archive::hdf5 {

/// An entry of a scale's REFERENCE_LIST. The entry names a dataset and the dimension to which the
/// scale is attached.
struct ScaleUse {
  haddr_t dataset = HADDR_UNDEF;  ///< address of the dataset's header
  std::uint32_t dimension = 0;
};

struct ObjectAttributes {
  std::vector<Attribute> content;  ///< attributes for the model
  bool is_bool = false;            ///< dtype = "bool"
  bool is_scale = false;           ///< CLASS = "DIMENSION_SCALE"
  bool is_bare_dimension = false;  ///< a scale without values, only for a size
  std::vector<ScaleUse> uses;
};

/// `path`: the object's name in messages. Throws as described in reader.h.
ObjectAttributes read_attributes(const Api& api, hid_t object, const std::string& path);

}  // namespace sleight::archive::hdf5
