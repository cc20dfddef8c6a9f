#include "common/archive/hdf5/attributes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "common/archive/format.h"
#include "common/archive/hdf5/storage.h"
#include "common/archive/limits.h"
#include "common/archive/text.h"

namespace sleight::archive::hdf5 {
namespace {

struct OpenAttribute {
  std::string name;
  Handle id;
  Handle type;
  Handle space;
};

OpenAttribute open_attribute(const Api& api, hid_t object, const std::string& path,
                             std::uint64_t index) {
  OpenAttribute attribute;
  attribute.id = api.id(
      H5Aopen_by_idx(object, ".", H5_INDEX_NAME, H5_ITER_INC, index, H5P_DEFAULT, H5P_DEFAULT),
      H5Aclose, path, "open an attribute");
  std::array<char, k_name_bytes_max + 1> name{};
  const std::uint64_t length = api.count(H5Aget_name(attribute.id.get(), name.size(), name.data()),
                                         path, "read an attribute's name");
  if (length > k_name_bytes_max || !is_plain_name(name.data())) {
    api.fail(path, "an attribute has an invalid name");
  }
  attribute.name = name.data();
  attribute.type =
      api.id(H5Aget_type(attribute.id.get()), H5Tclose, path, "read an attribute's datatype");
  attribute.space =
      api.id(H5Aget_space(attribute.id.get()), H5Sclose, path, "read an attribute's dataspace");
  return attribute;
}

std::string read_text(const Api& api, const OpenAttribute& attribute, const std::string& path) {
  const std::size_t size = H5Tget_size(attribute.type.get());
  if (H5Tget_class(attribute.type.get()) != H5T_STRING ||
      H5Tis_variable_str(attribute.type.get()) != 0 || size == 0 || size > k_attribute_bytes_max) {
    api.fail(path, fmt::format("the attribute {} is not a fixed-length text", attribute.name));
  }
  std::string text(size, '\0');
  api.ok(H5Aread(attribute.id.get(), attribute.type.get(), text.data()), path, "read an attribute");
  // A text ends at its first NUL character, whatever its padding.
  text.resize(std::min(text.find('\0'), text.size()));
  if (!is_clean_line(text)) {
    api.fail(path, fmt::format("the attribute {} contains control characters or is not UTF-8",
                               attribute.name));
  }
  return text;
}

Attribute read_content(const Api& api, const OpenAttribute& attribute, const std::string& path) {
  const hid_t type = attribute.type.get();
  Attribute content{.name = attribute.name, .value = std::int64_t{0}};
  if (H5Tequal(type, H5T_STD_I64LE) > 0) {
    std::int64_t value = 0;
    api.ok(H5Aread(attribute.id.get(), H5T_NATIVE_INT64, &value), path, "read an attribute");
    content.value = value;
  } else if (H5Tequal(type, H5T_IEEE_F64LE) > 0) {
    double value = 0;
    api.ok(H5Aread(attribute.id.get(), H5T_NATIVE_DOUBLE, &value), path, "read an attribute");
    content.value = value;
  } else {
    content.value = read_text(api, attribute, path);
  }
  return content;
}

/// Reads REFERENCE_LIST: an array of pairs (object reference, dimension). A pair has a fixed size.
std::vector<ScaleUse> read_uses(const Api& api, const OpenAttribute& attribute,
                                const std::string& path) {
  struct Pair {
    hobj_ref_t dataset;
    std::uint32_t dimension;
  };
  const hid_t type = attribute.type.get();
  bool fits = H5Tget_class(type) == H5T_COMPOUND && H5Tget_nmembers(type) == 2;
  for (unsigned i = 0; fits && i < 2; ++i) {
    const Handle member =
        api.id(H5Tget_member_type(type, i), H5Tclose, path, "read a member's datatype");
    fits = i == 0 ? H5Tequal(member.get(), H5T_STD_REF_OBJ) > 0
                  : H5Tget_class(member.get()) == H5T_INTEGER && H5Tget_size(member.get()) == 4;
  }
  const std::uint64_t count = api.count(H5Sget_simple_extent_npoints(attribute.space.get()), path,
                                        "read the size of the reference list");
  if (!fits || count > k_objects_max * k_rank_max) {
    api.fail(path, "the reference list of dimension scales is malformed");
  }
  const Handle memory =
      api.id(H5Tcreate(H5T_COMPOUND, sizeof(Pair)), H5Tclose, path, "create a datatype");
  api.ok(H5Tinsert(memory.get(), "dataset", HOFFSET(Pair, dataset), H5T_STD_REF_OBJ), path,
         "create a datatype");
  api.ok(H5Tinsert(memory.get(), "dimension", HOFFSET(Pair, dimension), H5T_NATIVE_UINT32), path,
         "create a datatype");
  std::vector<Pair> pairs(count, Pair{HADDR_UNDEF, 0});
  if (count != 0) {
    api.ok(H5Aread(attribute.id.get(), memory.get(), pairs.data()), path,
           "read the reference list");
  }
  std::vector<ScaleUse> uses;
  for (const Pair& pair : pairs)
    uses.push_back({pair.dataset, pair.dimension});
  return uses;
}

/// Returns whether the attribute belongs to dimension scales or netCDF-4. If so, stores the
/// attribute's meaning in `object`.
bool take_scale_attribute(const Api& api, const OpenAttribute& attribute, const std::string& path,
                          ObjectAttributes& object) {
  const std::string& name = attribute.name;
  if (name == k_dimension_list || name == k_netcdf_dimension_id || name == k_netcdf_coordinates) {
    return true;
  }
  if (name == k_reference_list) {
    object.uses = read_uses(api, attribute, path);
    return true;
  }
  if (H5Sget_simple_extent_type(attribute.space.get()) != H5S_SCALAR) {
    api.fail(path, fmt::format("the attribute {} is not a scalar", name));
  }
  if (name == k_class_attribute) {
    object.is_scale = read_text(api, attribute, path) == k_class_scale;
  } else if (name == k_name_attribute) {
    object.is_bare_dimension = read_text(api, attribute, path).starts_with(k_bare_dimension);
  } else if (name == k_dtype_attribute) {
    object.is_bool = read_text(api, attribute, path) == k_dtype_bool;
  } else {
    return name == k_encoding_attribute;
  }
  return true;
}

}  // namespace

ObjectAttributes read_attributes(const Api& api, hid_t object, const std::string& path) {
  H5O_info_t info{};
  api.ok(H5Oget_info2(object, &info, H5O_INFO_NUM_ATTRS), path, "count attributes");
  if (info.num_attrs > k_attributes_max) {
    api.fail(path, fmt::format("expected at most {1} attributes, found {0}", info.num_attrs,
                               k_attributes_max));
  }
  ObjectAttributes attributes;
  for (std::uint64_t i = 0; i < info.num_attrs; ++i) {
    const OpenAttribute attribute = open_attribute(api, object, path, i);
    if (H5Tcommitted(attribute.type.get()) != 0) {
      api.fail(path, fmt::format("the attribute {} has a committed datatype", attribute.name));
    }
    if (take_scale_attribute(api, attribute, path, attributes)) continue;
    if (find_attribute(attributes.content, attribute.name) != nullptr) {
      api.fail(path, fmt::format("two attributes are named {}", attribute.name));
    }
    attributes.content.push_back(read_content(api, attribute, path));
  }
  return attributes;
}

}  // namespace sleight::archive::hdf5
