#include "common/archive/hdf5/inspect.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

#include "common/archive/format.h"
#include "common/archive/hdf5/reader.h"
#include "common/archive/hdf5/storage.h"
#include "common/archive/limits.h"
#include "common/archive/text.h"
#include "common/base/check.h"

namespace sleight::archive::hdf5 {
namespace {

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

/// `path`: the object's name in messages. Throws as described in reader.h.
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

/// A dataset whose dimensions have no names yet.
struct FoundDataset {
  std::string name;
  haddr_t address = HADDR_UNDEF;
  ObjectAttributes attributes;
  StoredDataset stored;
};

struct FoundLink {
  std::string name;
  H5O_info_t info;
};

class Walk {
 public:
  Walk(const Api& api, hid_t file, std::uint64_t file_bytes)
      : api_(api), file_(file), file_bytes_(file_bytes) {}

  Contents run() {
    const Handle root = api_.id(H5Gopen2(file_, "/", H5P_DEFAULT), H5Gclose, k_root, "open");
    H5O_info_t info{};
    api_.ok(H5Oget_info2(root.get(), &info, H5O_INFO_BASIC), k_root, "describe");
    seen_.insert(info.addr);
    walk_group(root.get(), std::string(k_root), 0);
    return std::move(contents_);
  }

 private:
  void walk_group(hid_t id, const std::string& name, int depth) {
    Group group{.name = name};
    group.attributes = read_attributes(api_, id, name).content;
    if (depth == 0) check_format(group);
    std::vector<FoundDataset> datasets;
    std::vector<std::string> groups;
    for (FoundLink& link : links_of(id, name)) {
      const std::string path = path_of(name, link.name);
      check_object(link, path);
      if (link.info.type == H5O_TYPE_DATASET) {
        datasets.push_back(open_dataset(id, link, path));
      } else if (link.info.type == H5O_TYPE_GROUP && depth == 0) {
        groups.push_back(link.name);
      } else {
        api_.fail(path, depth == 0 ? "expected a group or a dataset"
                                   : "expected only datasets in a group below the root");
      }
    }
    name_dimensions(datasets, group);
    contents_.groups.push_back(std::move(group));
    for (const std::string& below : groups) {
      const std::string path = path_of(name, below);
      const Handle child =
          api_.id(H5Gopen2(id, below.c_str(), H5P_DEFAULT), H5Gclose, path, "open");
      walk_group(child.get(), path, depth + 1);
    }
  }

  void check_format(const Group& root) const {
    const Attribute* format = find_attribute(root.attributes, "format");
    const auto* text = format ? std::get_if<std::string>(&format->value) : nullptr;
    if (text == nullptr || *text != k_format_name) {
      api_.fail("", fmt::format("not a Sleight archive: the root attribute format = {} is missing",
                                k_format_name));
    }
    const Attribute* version = find_attribute(root.attributes, "format_version");
    const auto* number = version ? std::get_if<std::int64_t>(&version->value) : nullptr;
    if (number == nullptr || *number < 1)
      api_.fail("", "the root attribute format_version is missing");
    if (*number == k_format_version) return;
    const Attribute* writer = find_attribute(root.attributes, k_inference_library_version);
    const auto* by = writer ? std::get_if<std::string>(&writer->value) : nullptr;
    api_.fail("",
              fmt::format("sleight {} wrote this archive in format {}, but this program only reads "
                          "format {}; use that version of sleight, or run the request again",
                          by ? *by : "of an unknown version", *number, k_format_version));
  }

  /// Returns the links in creation order. If the file doesn't track creation order, returns the
  /// links by name.
  std::vector<FoundLink> links_of(hid_t group, const std::string& path) {
    H5G_info_t info{};
    api_.ok(H5Gget_info(group, &info), path, "list");
    if (info.nlinks > k_objects_max) {
      api_.fail(path,
                fmt::format("expected at most {1} objects, found {0}", info.nlinks, k_objects_max));
    }
    const Handle list =
        api_.id(H5Gget_create_plist(group), H5Pclose, path, "read the property list");
    unsigned order = 0;
    api_.ok(H5Pget_link_creation_order(list.get(), &order), path, "read the link order");
    const H5_index_t index =
        (order & H5P_CRT_ORDER_INDEXED) != 0 ? H5_INDEX_CRT_ORDER : H5_INDEX_NAME;
    std::vector<FoundLink> links;
    for (std::uint64_t i = 0; i < info.nlinks; ++i) {
      links.push_back(link_at(group, path, index, i));
    }
    return links;
  }

  FoundLink link_at(hid_t group, const std::string& path, H5_index_t index, std::uint64_t i) {
    std::array<char, k_name_bytes_max + 1> name{};
    const std::uint64_t length =
        api_.count(H5Lget_name_by_idx(group, ".", index, H5_ITER_INC, i, name.data(), name.size(),
                                      H5P_DEFAULT),
                   path, "read the name of an object");
    if (length > k_name_bytes_max || !is_plain_name(name.data())) {
      api_.fail(path, "an object in the group has an invalid name");
    }
    FoundLink link{.name = name.data(), .info = {}};
    H5L_info_t link_info{};
    api_.ok(H5Lget_info(group, name.data(), &link_info, H5P_DEFAULT), path_of(path, link.name),
            "describe the link");
    if (link_info.type != H5L_TYPE_HARD) {
      api_.fail(path_of(path, link.name),
                link_info.type == H5L_TYPE_SOFT
                    ? "soft links are not supported"
                    : "external and user-defined links are not supported");
    }
    api_.ok(H5Oget_info_by_name2(group, name.data(), &link.info, H5O_INFO_BASIC, H5P_DEFAULT),
            path_of(path, link.name), "describe");
    return link;
  }

  void check_object(const FoundLink& link, const std::string& path) {
    if (link.info.rc != 1 || !seen_.insert(link.info.addr).second) {
      api_.fail(path, "the object has several names");
    }
    if (seen_.size() > k_objects_max) {
      api_.fail(path, fmt::format("the file has more than {} objects", k_objects_max));
    }
  }

  FoundDataset open_dataset(hid_t group, const FoundLink& link, const std::string& path) {
    FoundDataset found{
        .name = link.name, .address = link.info.addr, .attributes = {}, .stored = {}};
    found.stored.id =
        api_.id(H5Dopen2(group, link.name.c_str(), H5P_DEFAULT), H5Dclose, path, "open");
    const hid_t id = found.stored.id.get();
    // Check the storage first, because reading a virtual dataset's space would access other files.
    const Handle list = api_.id(H5Dget_create_plist(id), H5Pclose, path, "read the property list");
    check_storage(list.get(), path);
    found.attributes = read_attributes(api_, id, path);
    const std::vector<std::uint64_t> file_dims = dims_of(id, path);
    if (found.attributes.is_bare_dimension) {
      found.stored.dims = file_dims;
      return found;
    }
    const std::size_t size = set_type(found, file_dims, path);
    check_size(id, list.get(), file_dims, size, path);
    return found;
  }

  void check_storage(hid_t list, const std::string& path) const {
    const H5D_layout_t layout = H5Pget_layout(list);
    if (layout == H5D_VIRTUAL) api_.fail(path, "virtual datasets are not supported");
    if (layout != H5D_CONTIGUOUS && layout != H5D_CHUNKED && layout != H5D_COMPACT) {
      api_.fail(path, "unknown storage layout");
    }
    if (api_.count(H5Pget_external_count(list), path, "read the storage layout") != 0) {
      api_.fail(path, "values in another file are not supported");
    }
    std::set<H5Z_filter_t> filters;
    const std::uint64_t count = api_.count(H5Pget_nfilters(list), path, "count filters");
    for (unsigned i = 0; i < count; ++i) {
      unsigned flags = 0;
      std::size_t values = 0;
      const H5Z_filter_t filter =
          H5Pget_filter2(list, i, &flags, &values, nullptr, 0, nullptr, nullptr);
      const bool known = filter == H5Z_FILTER_SHUFFLE || filter == H5Z_FILTER_DEFLATE ||
                         filter == H5Z_FILTER_FLETCHER32;
      if (!known) api_.fail(path, fmt::format("unknown filter {}", filter));
      if (!filters.insert(filter).second) {
        api_.fail(path, fmt::format("the filter {} is applied twice", filter));
      }
    }
  }

  std::vector<std::uint64_t> dims_of(hid_t id, const std::string& path) const {
    const Handle space = api_.id(H5Dget_space(id), H5Sclose, path, "read the dataspace");
    const H5S_class_t kind = H5Sget_simple_extent_type(space.get());
    if (kind == H5S_SCALAR) return {};
    const int rank = H5Sget_simple_extent_ndims(space.get());
    // In the file, a text array has one more dimension than in the model.
    if (kind != H5S_SIMPLE || rank < 1 || rank > static_cast<int>(k_rank_max) + 1) {
      api_.fail(path, fmt::format("expected at most {1} dimensions, found {0}", rank, k_rank_max));
    }
    std::vector<hsize_t> dims(static_cast<std::size_t>(rank));
    api_.ok(H5Sget_simple_extent_dims(space.get(), dims.data(), nullptr), path,
            "read the dimensions");
    return {dims.begin(), dims.end()};
  }

  /// Sets the model's type and dimensions, and returns the bytes per element in the file.
  std::size_t set_type(FoundDataset& found, const std::vector<std::uint64_t>& file_dims,
                       const std::string& path) const {
    const Handle type =
        api_.id(H5Dget_type(found.stored.id.get()), H5Tclose, path, "read the datatype");
    if (H5Tcommitted(type.get()) != 0) api_.fail(path, "committed datatypes are not supported");
    StoredDataset& stored = found.stored;
    stored.dims = file_dims;
    const auto is = [&type](hid_t expected) { return H5Tequal(type.get(), expected) > 0; };
    if (is(H5T_IEEE_F64LE)) {
      stored.type = ElementType::f64;
    } else if (is(H5T_STD_I64LE)) {
      stored.type = ElementType::i64;
    } else if (is(H5T_STD_I32LE)) {
      stored.type = ElementType::i32;
    } else if (is(H5T_STD_I8LE) && found.attributes.is_bool) {
      stored.type = ElementType::boolean;
    } else if (H5Tget_class(type.get()) == H5T_STRING && H5Tis_variable_str(type.get()) == 0) {
      set_text_type(stored, H5Tget_size(type.get()), path);
    } else {
      api_.fail(path, "the archive format does not allow this datatype");
    }
    if (stored.dims.size() > k_rank_max) {
      api_.fail(path, fmt::format("expected at most {1} dimensions, found {0}", stored.dims.size(),
                                  k_rank_max));
    }
    return H5Tget_size(type.get());
  }

  void set_text_type(StoredDataset& stored, std::size_t bytes, const std::string& path) const {
    stored.type = ElementType::text;
    stored.text_bytes = bytes;
    if (!stored.dims.empty()) {
      if (bytes != 1) api_.fail(path, "expected a text array of single characters");
      stored.text_bytes = stored.dims.back();
      stored.dims.pop_back();
      if (stored.dims.empty()) api_.fail(path, "a text array needs at least two dimensions");
    }
    if (stored.text_bytes == 0 || stored.text_bytes > k_text_bytes_max) {
      api_.fail(path, fmt::format("expected texts of 1 to {1} bytes, found {0}", stored.text_bytes,
                                  k_text_bytes_max));
    }
  }

  void check_size(hid_t id, hid_t list, const std::vector<std::uint64_t>& dims,
                  std::size_t element_bytes, const std::string& path) const {
    std::uint64_t bytes = element_bytes;
    for (const std::uint64_t dim : dims) {
      if (__builtin_mul_overflow(bytes, dim, &bytes)) bytes = ~std::uint64_t{0};
    }
    if (std::ranges::find(dims, 0U) != dims.end()) bytes = 0;
    if (bytes > k_dataset_bytes_max) {
      api_.fail(path, fmt::format("expected at most {1} bytes of values, found {0}", bytes,
                                  k_dataset_bytes_max));
    }
    if (bytes == 0) return;
    const std::uint64_t stored = H5Dget_storage_size(id);
    if (stored > file_bytes_)
      api_.fail(path, "the dataset's storage size exceeds the size of the file");
    std::uint64_t held = stored;
    if (H5Pget_layout(list) == H5D_CHUNKED) {
      check_chunks(id, list, dims, element_bytes, path);
      held = stored * k_deflate_ratio_max;
    }
    if (bytes > held) {
      api_.fail(path, fmt::format("the values take {} bytes, which is too many for {} stored bytes",
                                  bytes, stored));
    }
  }

  void check_chunks(hid_t id, hid_t list, const std::vector<std::uint64_t>& dims,
                    std::size_t element_bytes, const std::string& path) const {
    std::array<hsize_t, k_rank_max + 1> chunk{};
    const std::uint64_t rank =
        api_.count(H5Pget_chunk(list, static_cast<int>(chunk.size()), chunk.data()), path,
                   "read the chunk size");
    if (rank != dims.size())
      api_.fail(path, "the chunks and the dataset have different numbers of dimensions");
    std::uint64_t bytes = element_bytes;
    std::uint64_t expected = 1;
    for (std::size_t d = 0; d < dims.size(); ++d) {
      if (chunk[d] == 0 || __builtin_mul_overflow(bytes, chunk[d], &bytes) ||
          bytes > k_chunk_bytes_max) {
        api_.fail(path, fmt::format("chunks are larger than {} bytes", k_chunk_bytes_max));
      }
      expected *= (dims[d] - 1) / chunk[d] + 1;
    }
    const Handle space = api_.id(H5Dget_space(id), H5Sclose, path, "read the dataspace");
    hsize_t count = 0;
    api_.ok(H5Dget_num_chunks(id, space.get(), &count), path, "count chunks");
    if (count != expected) {
      api_.fail(path, fmt::format("expected {1} chunks, found {0}", count, expected));
    }
  }

  /// Fills a group of the archive model from the datasets found in the file. The names of
  /// dimensions come from the dimension scales.
  void name_dimensions(std::vector<FoundDataset>& datasets, Group& group) {
    for (FoundDataset& found : datasets) {
      if (found.attributes.is_bare_dimension) continue;
      const std::string path = path_of(group.name, found.name);
      DatasetSpec spec{.name = found.name,
                       .type = found.stored.type,
                       .attributes = std::move(found.attributes.content),
                       .text_bytes = found.stored.text_bytes};
      for (std::size_t d = 0; d < found.stored.dims.size(); ++d) {
        spec.dims.push_back({dimension_name(datasets, found, d, path), found.stored.dims[d]});
      }
      group.datasets.push_back(std::move(spec));
      contents_.datasets.emplace(path, std::move(found.stored));
    }
  }

  std::string dimension_name(const std::vector<FoundDataset>& datasets, const FoundDataset& found,
                             std::size_t d, const std::string& path) const {
    if (found.attributes.is_scale) {
      if (found.stored.dims.size() != 1) {
        api_.fail(path, "a dimension scale must have one dimension");
      }
      return found.name;
    }
    std::string name;
    for (const FoundDataset& scale : datasets) {
      if (!scale.attributes.is_scale || scale.attributes.is_bare_dimension) continue;
      for (const ScaleUse& use : scale.attributes.uses) {
        if (use.dataset != found.address || use.dimension != d) continue;
        if (!name.empty()) api_.fail(path, fmt::format("dimension {} has two scales", d));
        name = scale.name;
      }
    }
    if (name.empty()) api_.fail(path, fmt::format("dimension {} has no scale", d));
    return name;
  }

  const Api& api_;
  hid_t file_;
  std::uint64_t file_bytes_;
  std::set<haddr_t> seen_;
  Contents contents_;
};

}  // namespace

Contents inspect(const Api& api, hid_t file, std::uint64_t file_bytes) {
  return Walk(api, file, file_bytes).run();
}

}  // namespace sleight::archive::hdf5
