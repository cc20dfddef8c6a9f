#include "common/archive/hdf5/writer.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <vector>

#include <fmt/format.h>
#include <hdf5_hl.h>
#include <unistd.h>

#include "common/archive/digest/digest.h"
#include "common/archive/format.h"
#include "common/archive/hdf5/boxes.h"
#include "common/archive/hdf5/handle.h"
#include "common/archive/hdf5/output_file.h"
#include "common/archive/hdf5/storage.h"
#include "common/base/check.h"

namespace sleight::archive::hdf5 {
namespace {

class FileSink final : public Sink {
 public:
  /// Creates the HDF5 file in `output`. Both arguments must outlive the sink.
  FileSink(const Api& api, OutputFile& output);

  void create_group(std::string_view group) override;
  void set_attribute(std::string_view group, const Attribute& attribute) override;
  DatasetHandle create_dataset(std::string_view group, const DatasetSpec& spec) override;
  void append(DatasetHandle dataset, const ValuesView& values) override;
  /// Connects dimensions with their coordinates and closes the file.
  void finish() override;

 private:
  struct Dataset {
    std::string group;
    DatasetSpec spec;
    std::string path;
    Handle id{};
    std::vector<std::uint64_t> dims{};  ///< of the file's dataset, without the text width
    std::uint64_t position = 0;         ///< elements appended
    std::int32_t dimension_id = -1;     ///< if the dataset is a coordinate
  };
  /// A dimension scale for the width of one group's text arrays.
  struct Width {
    Handle id;
    std::int32_t dimension_id = -1;
  };

  hid_t group_id(std::string_view name) const;
  void put_text(hid_t object, const std::string& path, const char* name, const std::string& text);
  void put_attribute(hid_t object, const std::string& path, const Attribute& attribute);
  void put_integers(hid_t object, const std::string& path, const char* name,
                    const std::vector<std::int32_t>& values, bool scalar);
  Width& width_of(const std::string& group, std::size_t bytes);
  void grow(Dataset& dataset, std::uint64_t elements);
  void write_box(Dataset& dataset, const ValuesView& values, std::uint64_t offset,
                 std::uint64_t left, std::uint64_t& written);
  void make_scales();
  void attach_scales(const Dataset& dataset);
  const Dataset& coordinate_of(const std::string& group, const std::string& dim) const;

  const Api& api_;
  OutputFile& output_;
  Handle file_;
  std::map<std::string, Handle, std::less<>> groups_;
  std::vector<Dataset> datasets_;
  std::map<std::string, Width> widths_;  ///< by path
  std::int32_t next_dimension_id_ = 0;
};

/// Largest fixed-size dataset that is stored uncompressed. Compression would save less than a chunk
/// costs.
constexpr std::uint64_t k_contiguous_bytes_max = 64 * 1024;
/// Deflate's compression level. Higher levels take three times as long and make the file only some
/// percent smaller.
constexpr unsigned k_deflate_level = 1;
/// If the first dimension grows, runs are split into boxes as if it had this size.
constexpr std::uint64_t k_unbounded = std::uint64_t{1} << 62;

bool is_text_array(const DatasetSpec& spec) {
  return spec.type == ElementType::text && !spec.dims.empty();
}

bool is_coordinate(const DatasetSpec& spec) {
  return spec.dims.size() == 1 && spec.dims[0].name == spec.name;
}

bool grows(const DatasetSpec& spec) {
  return !spec.dims.empty() && spec.dims[0].size == k_growing;
}

/// Returns at least 1, because HDF5 does not allow strings of zero bytes.
std::size_t width_in_file(std::size_t bytes) {
  return std::max<std::size_t>(1, bytes);
}

/// Returns the bytes of one text element. A scalar text is stored with its NUL, because netCDF-C
/// 4.9.0 reads until it finds a NUL.
std::size_t width_in_file(const DatasetSpec& spec) {
  return spec.dims.empty() ? spec.text_bytes + 1 : width_in_file(spec.text_bytes);
}

Handle fixed_text_type(const Api& api, std::size_t bytes, H5T_str_t padding) {
  Handle type = api.id(H5Tcopy(H5T_C_S1), H5Tclose, "", "create a text type");
  api.ok(H5Tset_size(type.get(), bytes), "", "set the size of a string type");
  api.ok(H5Tset_strpad(type.get(), padding), "", "set the padding of a text type");
  api.ok(H5Tset_cset(type.get(), H5T_CSET_UTF8), "", "set the encoding of a text type");
  return type;
}

/// Returns the single-character type that netCDF maps to "char".
Handle character_type(const Api& api) {
  return api.id(H5Tcopy(H5T_C_S1), H5Tclose, "", "create a character type");
}

hid_t plain_file_type(ElementType type) {
  switch (type) {
    case ElementType::f64:
      return H5T_IEEE_F64LE;
    case ElementType::i64:
      return H5T_STD_I64LE;
    case ElementType::i32:
      return H5T_STD_I32LE;
    case ElementType::boolean:
      return H5T_STD_I8LE;
    case ElementType::text:
      break;
  }
  base::check_failed("the type is numeric", std::to_string(static_cast<int>(type)));
}

Handle file_type(const Api& api, const DatasetSpec& spec) {
  if (is_text_array(spec)) return character_type(api);
  if (spec.type == ElementType::text) {
    return fixed_text_type(api, width_in_file(spec), H5T_STR_NULLTERM);
  }
  return api.id(H5Tcopy(plain_file_type(spec.type)), H5Tclose, spec.name, "create a datatype");
}

/// Makes files and groups store no times, and track creation order, as netCDF-4 expects.
void set_group_order(const Api& api, hid_t list) {
  constexpr unsigned order = H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED;
  api.ok(H5Pset_obj_track_times(list, false), "", "disable object times");
  api.ok(H5Pset_link_creation_order(list, order), "", "track the order of links");
  api.ok(H5Pset_attr_creation_order(list, order), "", "track the order of attributes");
}

/// Returns the shape of a chunk that has a batch's worth of elements. Inner dimensions are filled
/// first. So elements that are written together, or read along the last dimensions, are contiguous.
std::vector<hsize_t> chunk_of(const std::vector<std::uint64_t>& dims) {
  std::vector<hsize_t> chunk(dims.size(), 1);
  std::uint64_t left = k_batch_elements;
  for (std::size_t d = dims.size(); d-- > 0 && left > 0;) {
    chunk[d] = std::clamp<std::uint64_t>(dims[d], 1, left);
    left /= chunk[d];
  }
  return chunk;
}

Handle creation_list(const Api& api, const DatasetSpec& spec,
                     const std::vector<std::uint64_t>& dims) {
  Handle list =
      api.id(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, spec.name, "create a property list");
  api.ok(H5Pset_obj_track_times(list.get(), false), spec.name, "disable object times");
  api.ok(H5Pset_attr_creation_order(list.get(), H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED),
         spec.name, "track the order of attributes");
  // Set a fill value, because otherwise the unused rest of a last chunk would have undefined bytes.
  api.ok(H5Pset_fill_time(list.get(), H5D_FILL_TIME_ALLOC), spec.name, "set the fill time");
  const std::uint64_t bytes = grows(spec) ? 0 : element_count(spec) * 8;
  if (spec.type == ElementType::text || (!grows(spec) && bytes <= k_contiguous_bytes_max)) {
    return list;
  }
  const std::vector<hsize_t> chunk = chunk_of(dims);
  api.ok(H5Pset_chunk(list.get(), static_cast<int>(chunk.size()), chunk.data()), spec.name,
         "set the chunk size");
  api.ok(H5Pset_shuffle(list.get()), spec.name, "set the shuffle filter");
  api.ok(H5Pset_deflate(list.get(), k_deflate_level), spec.name, "set the deflate filter");
  return list;
}

Handle dataspace(const Api& api, const DatasetSpec& spec, std::vector<std::uint64_t> dims) {
  if (dims.empty()) return api.id(H5Screate(H5S_SCALAR), H5Sclose, spec.name, "create a dataspace");
  std::vector<hsize_t> size(dims.begin(), dims.end());
  std::vector<hsize_t> most = size;
  if (grows(spec)) {
    size[0] = 0;
    most[0] = H5S_UNLIMITED;
  }
  if (is_text_array(spec)) {
    size.push_back(width_in_file(spec));
    most.push_back(size.back());
  }
  return api.id(H5Screate_simple(static_cast<int>(size.size()), size.data(), most.data()), H5Sclose,
                spec.name, "create a dataspace");
}

/// Concatenates the texts, each padded with NUL characters.
std::string padded(std::span<const std::string> texts, std::size_t width) {
  std::string bytes;
  for (const std::string& text : texts) {
    bytes += text;
    bytes.append(width - text.size(), '\0');
  }
  return bytes;
}

hid_t memory_type(const ValuesView& values) {
  switch (type_of(values)) {
    case ElementType::f64:
      return H5T_NATIVE_DOUBLE;
    case ElementType::i64:
      return H5T_NATIVE_INT64;
    case ElementType::i32:
      return H5T_NATIVE_INT32;
    case ElementType::boolean:
      return H5T_NATIVE_INT8;
    case ElementType::text:
      break;
  }
  base::check_failed("the type is numeric", "text");
}

const void* address_of(const ValuesView& values, std::uint64_t offset) {
  return std::visit([offset](const auto& span) -> const void* { return span.data() + offset; },
                    values);
}

FileSink::FileSink(const Api& api, OutputFile& output) : api_(api), output_(output) {
  const Handle access =
      api.id(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "", "create a file-access list");
  api.ok(output.use_in(access.get()), "", "set the file driver");
  const Handle creation =
      api.id(H5Pcreate(H5P_FILE_CREATE), H5Pclose, "", "create a property list");
  set_group_order(api, creation.get());
  file_ = api.id(H5Fcreate(api.path().c_str(), H5F_ACC_TRUNC, creation.get(), access.get()),
                 H5Fclose, "", "create the file");
  groups_.emplace(k_root,
                  api.id(H5Gopen2(file_.get(), "/", H5P_DEFAULT), H5Gclose, k_root, "open"));
}

hid_t FileSink::group_id(std::string_view name) const {
  const auto found = groups_.find(name);
  CHECK(found != groups_.end());
  return found->second.get();
}

void FileSink::create_group(std::string_view group) {
  const Handle list =
      api_.id(H5Pcreate(H5P_GROUP_CREATE), H5Pclose, group, "create a property list");
  set_group_order(api_, list.get());
  const std::string name(group.substr(1));
  groups_.emplace(
      group, api_.id(H5Gcreate2(file_.get(), name.c_str(), H5P_DEFAULT, list.get(), H5P_DEFAULT),
                     H5Gclose, group, "create"));
}

void FileSink::put_text(hid_t object, const std::string& path, const char* name,
                        const std::string& text) {
  const Handle type = fixed_text_type(api_, width_in_file(text.size()), H5T_STR_NULLPAD);
  const Handle space = api_.id(H5Screate(H5S_SCALAR), H5Sclose, path, "create a dataspace");
  Handle id = api_.id(H5Acreate2(object, name, type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT),
                      H5Aclose, path, "create an attribute");
  const std::string bytes = padded({&text, 1}, width_in_file(text.size()));
  api_.ok(H5Awrite(id.get(), type.get(), bytes.data()), path, "write an attribute");
}

void FileSink::put_attribute(hid_t object, const std::string& path, const Attribute& attribute) {
  CHECK_NE(attribute.name, k_dtype_attribute);
  CHECK_NE(attribute.name, k_encoding_attribute);
  if (const auto* text = std::get_if<std::string>(&attribute.value)) {
    put_text(object, path, attribute.name.c_str(), *text);
    return;
  }
  const auto* number = std::get_if<double>(&attribute.value);
  const void* value = number;
  if (number == nullptr) value = &std::get<std::int64_t>(attribute.value);
  const Handle space = api_.id(H5Screate(H5S_SCALAR), H5Sclose, path, "create a dataspace");
  Handle id =
      api_.id(H5Acreate2(object, attribute.name.c_str(), number ? H5T_IEEE_F64LE : H5T_STD_I64LE,
                         space.get(), H5P_DEFAULT, H5P_DEFAULT),
              H5Aclose, path, "create an attribute");
  api_.ok(H5Awrite(id.get(), number ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT64, value), path,
          "write an attribute");
}

void FileSink::put_integers(hid_t object, const std::string& path, const char* name,
                            const std::vector<std::int32_t>& values, bool scalar) {
  const hsize_t size = values.size();
  const Handle space = api_.id(scalar ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &size, nullptr),
                               H5Sclose, path, "create a dataspace");
  Handle id =
      api_.id(H5Acreate2(object, name, H5T_STD_I32LE, space.get(), H5P_DEFAULT, H5P_DEFAULT),
              H5Aclose, path, "create an attribute");
  api_.ok(H5Awrite(id.get(), H5T_NATIVE_INT32, values.data()), path, "write an attribute");
}

void FileSink::set_attribute(std::string_view group, const Attribute& attribute) {
  put_attribute(group_id(group), std::string(group), attribute);
}

Sink::DatasetHandle FileSink::create_dataset(std::string_view group, const DatasetSpec& spec) {
  Dataset dataset{.group = std::string(group), .spec = spec, .path = path_of(group, spec.name)};
  for (const Dimension& dim : spec.dims) {
    dataset.dims.push_back(dim.size == k_growing ? k_unbounded : dim.size);
  }
  const Handle type = file_type(api_, spec);
  const Handle space = dataspace(api_, spec, dataset.dims);
  const Handle list = creation_list(api_, spec, dataset.dims);
  dataset.id = api_.id(H5Dcreate2(group_id(group), spec.name.c_str(), type.get(), space.get(),
                                  H5P_DEFAULT, list.get(), H5P_DEFAULT),
                       H5Dclose, dataset.path, "create");
  const hid_t id = dataset.id.get();
  for (const Attribute& attribute : spec.attributes)
    put_attribute(id, dataset.path, attribute);
  if (spec.type == ElementType::boolean) {
    put_text(id, dataset.path, k_dtype_attribute, k_dtype_bool);
  }
  if (is_text_array(spec)) put_text(id, dataset.path, k_encoding_attribute, k_encoding_utf8);
  datasets_.push_back(std::move(dataset));
  return datasets_.size() - 1;
}

void FileSink::grow(Dataset& dataset, std::uint64_t elements) {
  if (!grows(dataset.spec)) return;
  std::uint64_t row = 1;
  for (std::size_t d = 1; d < dataset.dims.size(); ++d)
    row *= dataset.dims[d];
  std::vector<hsize_t> size(dataset.dims.begin(), dataset.dims.end());
  size[0] = (dataset.position + elements + row - 1) / row;
  api_.ok(H5Dset_extent(dataset.id.get(), size.data()), dataset.path, "extend");
}

void FileSink::append(DatasetHandle handle, const ValuesView& values) {
  CHECK_LT(handle, datasets_.size());
  Dataset& dataset = datasets_[handle];
  const std::uint64_t total = count_of(values);
  grow(dataset, total);
  for (std::uint64_t offset = 0; offset < total;) {
    std::uint64_t written = 0;
    write_box(dataset, values, offset, total - offset, written);
    offset += written;
    dataset.position += written;
  }
  output_.throw_failure();
}

void FileSink::write_box(Dataset& dataset, const ValuesView& values, std::uint64_t offset,
                         std::uint64_t left, std::uint64_t& written) {
  Box box = box_at(dataset.dims, dataset.position, left);
  written = box.elements;
  const hid_t id = dataset.id.get();
  const Handle space = api_.id(H5Dget_space(id), H5Sclose, dataset.path, "read the dataspace");
  hsize_t in_memory = box.elements;
  std::string text;
  if (const auto* texts = std::get_if<std::span<const std::string>>(&values)) {
    const std::size_t width = width_in_file(dataset.spec);
    text = padded(texts->subspan(offset, box.elements), width);
    if (is_text_array(dataset.spec)) {
      box.start.push_back(0);
      box.count.push_back(width);
      in_memory *= width;
    }
  }
  if (!box.start.empty()) {
    const std::vector<hsize_t> start(box.start.begin(), box.start.end());
    const std::vector<hsize_t> count(box.count.begin(), box.count.end());
    api_.ok(H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(),
                                nullptr),
            dataset.path, "select a part");
  }
  const Handle memory = api_.id(H5Screate_simple(1, &in_memory, nullptr), H5Sclose, dataset.path,
                                "create a dataspace");
  const Handle type =
      dataset.spec.type == ElementType::text
          ? file_type(api_, dataset.spec)
          : api_.id(H5Tcopy(memory_type(values)), H5Tclose, dataset.path, "create a datatype");
  const void* data =
      dataset.spec.type == ElementType::text ? text.data() : address_of(values, offset);
  api_.ok(H5Dwrite(id, type.get(), memory.get(), space.get(), H5P_DEFAULT, data), dataset.path,
          "write");
}

FileSink::Width& FileSink::width_of(const std::string& group, std::size_t bytes) {
  const hsize_t width = width_in_file(bytes);
  const std::string name = fmt::format("string{}", width);
  const std::string path = path_of(group, name);
  const auto [found, is_new] = widths_.try_emplace(path);
  if (!is_new) return found->second;
  Width& scale = found->second;
  const Handle space =
      api_.id(H5Screate_simple(1, &width, nullptr), H5Sclose, path, "create a dataspace");
  const Handle list =
      api_.id(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, path, "create a property list");
  api_.ok(H5Pset_obj_track_times(list.get(), false), path, "disable object times");
  api_.ok(H5Pset_attr_creation_order(list.get(), H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED),
          path, "track the order of attributes");
  scale.id = api_.id(H5Dcreate2(group_id(group), name.c_str(), H5T_IEEE_F32BE, space.get(),
                                H5P_DEFAULT, list.get(), H5P_DEFAULT),
                     H5Dclose, path, "create");
  api_.ok(H5DSset_scale(scale.id.get(), fmt::format("{}{:10}", k_bare_dimension, width).c_str()),
          path, "make a dimension scale");
  scale.dimension_id = next_dimension_id_++;
  put_integers(scale.id.get(), path, k_netcdf_dimension_id, {scale.dimension_id}, true);
  return scale;
}

void FileSink::make_scales() {
  for (Dataset& dataset : datasets_) {
    if (!is_coordinate(dataset.spec)) continue;
    const hid_t id = dataset.id.get();
    api_.ok(H5DSset_scale(id, dataset.spec.name.c_str()), dataset.path, "make a dimension scale");
    dataset.dimension_id = next_dimension_id_++;
    put_integers(id, dataset.path, k_netcdf_dimension_id, {dataset.dimension_id}, true);
    if (!is_text_array(dataset.spec)) continue;
    // A scale can't have scales, so netCDF-4 names its second dimension by number.
    const Width& width = width_of(dataset.group, dataset.spec.text_bytes);
    put_integers(id, dataset.path, k_netcdf_coordinates, {dataset.dimension_id, width.dimension_id},
                 false);
  }
}

const FileSink::Dataset& FileSink::coordinate_of(const std::string& group,
                                                 const std::string& dim) const {
  const auto found = std::ranges::find_if(datasets_, [&](const Dataset& dataset) {
    return dataset.group == group && dataset.spec.name == dim && is_coordinate(dataset.spec);
  });
  CHECK(found != datasets_.end());
  return *found;
}

void FileSink::attach_scales(const Dataset& dataset) {
  const hid_t id = dataset.id.get();
  for (unsigned d = 0; d < dataset.spec.dims.size(); ++d) {
    const Dataset& scale = coordinate_of(dataset.group, dataset.spec.dims[d].name);
    api_.ok(H5DSattach_scale(id, scale.id.get(), d), dataset.path, "attach a dimension scale");
  }
  if (is_text_array(dataset.spec)) {
    const Width& width = width_of(dataset.group, dataset.spec.text_bytes);
    api_.ok(H5DSattach_scale(id, width.id.get(), static_cast<unsigned>(dataset.spec.dims.size())),
            dataset.path, "attach a dimension scale");
  }
}

void FileSink::finish() {
  make_scales();
  for (const Dataset& dataset : datasets_) {
    if (!is_coordinate(dataset.spec)) attach_scales(dataset);
  }
  for (Dataset& dataset : datasets_)
    api_.ok(dataset.id.close(), dataset.path, "close");
  for (auto& [path, width] : widths_)
    api_.ok(width.id.close(), path, "close");
  for (auto& [name, group] : groups_)
    api_.ok(group.close(), name, "close");
  api_.ok(file_.close(), "", "close the file");
  output_.throw_failure();
}

/// Removes the temporary file, unless it was renamed to the archive's path.
class Temporary {
 public:
  Temporary(base::FileSystem& file_system, std::string path)
      : file_system_(file_system), path_(std::move(path)) {}
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  ~Temporary() {
    if (placed_) return;
    try {
      file_system_.remove(path_);
    } catch (const base::Error&) {
      // Ignore failures here, because an earlier failure is being reported.
    }
  }

  const std::string& path() const { return path_; }
  void set_placed() { placed_ = true; }

 private:
  base::FileSystem& file_system_;
  std::string path_;
  bool placed_ = false;
};

std::string write_whole(const std::string& path, base::FileSystem& file_system,
                        const std::function<void(Sink&)>& fill) {
  const Api api(path, base::ExitCode::environment);
  OutputFile output(path, file_system);
  FileSink sink(api, output);
  std::string digest = write_digested(sink, fill);
  output.close();
  return digest;
}

}  // namespace

std::string write_file(const std::string& path, base::FileSystem& file_system,
                       const std::function<void(Sink&)>& fill) {
  Temporary temporary(file_system, fmt::format("{}.tmp.{}", path, ::getpid()));
  const std::string digest = write_whole(temporary.path(), file_system, fill);
  file_system.sync_file(temporary.path());
  file_system.rename(temporary.path(), path);
  temporary.set_placed();
  file_system.sync_directory_of(path);
  return digest;
}

}  // namespace sleight::archive::hdf5
