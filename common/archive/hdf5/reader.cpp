#include "common/archive/hdf5/reader.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "common/archive/format.h"
#include "common/archive/hdf5/boxes.h"
#include "common/archive/hdf5/handle.h"
#include "common/archive/hdf5/input_file.h"
#include "common/archive/hdf5/inspect.h"
#include "common/archive/limits.h"
#include "common/archive/text.h"
#include "common/base/check.h"
#include "common/base/descriptor.h"

namespace sleight::archive::hdf5 {
namespace {

class FileSource final : public Source {
 public:
  FileSource(Api api, std::unique_ptr<InputFile> input, Handle file, Contents contents)
      : api_(std::move(api)),
        input_(std::move(input)),
        file_(std::move(file)),
        contents_(std::move(contents)) {}

  std::string name() const override { return api_.path(); }
  const std::vector<Group>& groups() const override { return contents_.groups; }

  Values read(std::string_view group, std::string_view dataset, std::uint64_t first,
              std::uint64_t count) const override {
    const std::string path = path_of(group, dataset);
    const auto found = contents_.datasets.find(path);
    CHECK(found != contents_.datasets.end());
    const StoredDataset& stored = found->second;
    std::uint64_t total = 1;
    for (const std::uint64_t dim : stored.dims)
      total *= dim;
    CHECK_LE(first, total);
    CHECK_LE(count, total - first);
    switch (stored.type) {
      case ElementType::f64:
        return read_numbers<double>(path, stored, H5T_NATIVE_DOUBLE, first, count);
      case ElementType::i64:
        return read_numbers<std::int64_t>(path, stored, H5T_NATIVE_INT64, first, count);
      case ElementType::i32:
        return read_numbers<std::int32_t>(path, stored, H5T_NATIVE_INT32, first, count);
      case ElementType::boolean:
        return read_numbers<std::int8_t>(path, stored, H5T_NATIVE_INT8, first, count);
      case ElementType::text:
        return read_texts(path, stored, first, count);
    }
    base::check_failed("the element type is known", path);
  }

 private:
  template <class Number>
  std::vector<Number> read_numbers(const std::string& path, const StoredDataset& stored, hid_t type,
                                   std::uint64_t first, std::uint64_t count) const {
    std::vector<Number> values(count);
    read_boxes(path, stored, type, first, count,
               [&values](std::uint64_t offset) { return values.data() + offset; });
    return values;
  }

  std::vector<std::string> read_texts(const std::string& path, const StoredDataset& stored,
                                      std::uint64_t first, std::uint64_t count) const {
    const std::uint64_t width = stored.text_bytes;
    // A text array within k_dataset_bytes_max may still exceed the memory.
    if (count * width > k_text_bytes_max) api_.fail(path, "texts are too long");
    const Handle type = api_.id(H5Dget_type(stored.id.get()), H5Tclose, path, "read the datatype");
    std::string bytes(count * width, '\0');
    read_boxes(path, stored, type.get(), first, count,
               [&bytes, width](std::uint64_t offset) { return bytes.data() + offset * width; });
    std::vector<std::string> texts;
    for (std::uint64_t i = 0; i < count; ++i) {
      std::string text = bytes.substr(i * width, width);
      text.resize(std::min(text.find('\0'), text.size()));
      // Only the request's text may have several lines.
      const bool clean =
          path == path_of(k_root, k_request) ? is_clean_text(text) : is_clean_line(text);
      if (!clean) api_.fail(path, "the text contains control characters or is not UTF-8");
      texts.push_back(std::move(text));
    }
    return texts;
  }

  template <class Address>
  void read_boxes(const std::string& path, const StoredDataset& stored, hid_t type,
                  std::uint64_t first, std::uint64_t count, const Address& address) const {
    for (std::uint64_t offset = 0; offset < count;) {
      const Box box = box_at(stored.dims, first + offset, count - offset);
      read_box(path, stored, type, box, address(offset));
      offset += box.elements;
    }
  }

  void read_box(const std::string& path, const StoredDataset& stored, hid_t type, const Box& box,
                void* out) const {
    const Handle space =
        api_.id(H5Dget_space(stored.id.get()), H5Sclose, path, "read the dataspace");
    std::vector<hsize_t> start(box.start.begin(), box.start.end());
    std::vector<hsize_t> size(box.count.begin(), box.count.end());
    hsize_t in_memory = box.elements;
    if (stored.type == ElementType::text && !start.empty()) {
      start.push_back(0);
      size.push_back(stored.text_bytes);
      in_memory *= stored.text_bytes;
    }
    if (!start.empty()) {
      api_.ok(H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, size.data(),
                                  nullptr),
              path, "select a part");
    }
    const Handle memory =
        api_.id(H5Screate_simple(1, &in_memory, nullptr), H5Sclose, path, "create a dataspace");
    api_.ok(H5Dread(stored.id.get(), type, memory.get(), space.get(), H5P_DEFAULT, out), path,
            "read");
  }

  Api api_;
  std::unique_ptr<InputFile> input_;
  Handle file_;
  Contents contents_;  // declared after the file, so that its datasets close first
};

}  // namespace

void start() {
  const Api started("HDF5", base::ExitCode::bug);
}

std::unique_ptr<Source> open_file(const std::string& path) {
  start();
  // Open without blocking, in case the file is a pipe or a device.
  base::Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  struct stat status {};
  if (!file || ::fstat(file.get(), &status) != 0) {
    throw base::Error(fmt::format("{}: can't open: {}", path, std::strerror(errno)));
  }
  if (!S_ISREG(status.st_mode))
    Api(path, base::ExitCode::bad_archive).fail("", "not a regular file");
  return open_descriptor(
      path, {.descriptor = file.release(), .bytes = static_cast<std::uint64_t>(status.st_size)});
}

std::unique_ptr<Source> open_descriptor(const std::string& name, const OpenFile& open) {
  auto input = std::make_unique<InputFile>(open.descriptor, open.bytes);
  Api api(name, base::ExitCode::bad_archive);
  const Handle access =
      api.id(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "", "create a file-access list");
  api.ok(input->use_in(access.get()), "", "set the file driver");
  api.ok(H5Pset_fclose_degree(access.get(), H5F_CLOSE_STRONG), "", "set the close degree");
  if (!input->has_signature()) api.fail("", "not an HDF5 file");
  // The driver ignores the name, but a relative name would make HDF5 query the working folder.
  Handle file =
      api.id(H5Fopen("/archive", H5F_ACC_RDONLY, access.get()), H5Fclose, "", "open as HDF5");
  Contents contents = inspect(api, file.get(), open.bytes);
  return std::make_unique<FileSource>(std::move(api), std::move(input), std::move(file),
                                      std::move(contents));
}

}  // namespace sleight::archive::hdf5
