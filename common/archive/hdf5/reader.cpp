#include "common/archive/hdf5/reader.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <hdf5.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <string_view>
#include <utility>

#include "common/archive/format.h"
#include "common/archive/hdf5/boxes.h"
#include "common/archive/hdf5/driver.h"
#include "common/archive/hdf5/handle.h"
#include "common/archive/hdf5/inspect.h"
#include "common/archive/limits.h"
#include "common/archive/text.h"
#include "common/base/check.h"
#include "common/base/descriptor.h"

namespace sleight::archive::hdf5 {
namespace {

/// An HDF5 file driver that reads an archive from an open descriptor. HDF5's own driver opens files
/// by name, but the reader process (archive/reader_program) gives up the right to open files after
/// it has opened its archive.
class InputFile {
 public:
  /// Takes ownership of `descriptor`. `bytes`: length of the file.
  InputFile(int descriptor, std::uint64_t bytes) : state_{descriptor, bytes, 0} {}
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  ~InputFile();

  /// Sets the driver in a file-access list. H5Fopen with this list then reads this file and ignores
  /// the name. Returns a negative value on failure, like HDF5. The list may be used once, during
  /// this object's life.
  herr_t use_in(hid_t file_access_list);

  /// Returns whether the file has HDF5's signature at a position that HDF5 permits.
  bool has_signature() const;

  struct State {
    int descriptor = -1;
    std::uint64_t bytes = 0;
    std::uint64_t allocated = 0;  ///< HDF5's end of allocation
  };

 private:
  State state_;
};

using ReadState = InputFile::State;

/// Reads `size` bytes of the file from `address` on. Bytes past the file's end are zeros. Returns
/// false if the disk fails.
bool read_at(int descriptor, std::uint64_t address, std::byte* to, std::size_t size) {
  while (size > 0) {
    const ssize_t got = ::pread(descriptor, to, size, static_cast<off_t>(address));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return false;
    if (got == 0) {
      std::memset(to, 0, size);
      return true;
    }
    to += got;
    address += static_cast<std::uint64_t>(got);
    size -= static_cast<std::size_t>(got);
  }
  return true;
}

H5FD_t* begin_reading(const char* name, unsigned flags, hid_t list, haddr_t address) {
  if ((flags & H5F_ACC_RDWR) != 0) return nullptr;
  return open_driver_file<ReadState>(name, flags, list, address);
}

herr_t reading_features(const H5FD_t*, unsigned long* flags) {
  *flags = H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
  return 0;
}

haddr_t reading_eof(const H5FD_t* file, H5FD_mem_t) {
  return state_of<ReadState>(file).bytes;
}

herr_t read_part(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t address, std::size_t size, void* buffer) {
  const ReadState& state = state_of<ReadState>(file);
  haddr_t end = 0;
  if (__builtin_add_overflow(address, size, &end) || end > state.allocated) return -1;
  return read_at(state.descriptor, address, static_cast<std::byte*>(buffer), size) ? 0 : -1;
}

herr_t refuse_to_write(H5FD_t*, H5FD_mem_t, hid_t, haddr_t, std::size_t, const void*) {
  return -1;
}

H5FD_class_t reading_driver() {
  H5FD_class_t driver = driver_for<ReadState>("sleight_input");
  driver.open = begin_reading;
  driver.query = reading_features;
  driver.get_eof = reading_eof;
  driver.read = read_part;
  driver.write = refuse_to_write;
  return driver;
}

InputFile::~InputFile() {
  ::close(state_.descriptor);
}

herr_t InputFile::use_in(hid_t file_access_list) {
  static const H5FD_class_t driver = reading_driver();
  static const hid_t driver_id = H5FDregister(&driver);
  return use_driver(file_access_list, driver_id, state_);
}

bool InputFile::has_signature() const {
  constexpr std::string_view k_signature = "\211HDF\r\n\032\n";
  constexpr std::uint64_t k_first_place_after_begin = 512;
  std::array<char, k_signature.size()> found{};
  for (std::uint64_t place = 0; place + found.size() <= state_.bytes;
       place = place == 0 ? k_first_place_after_begin : 2 * place) {
    if (!read_at(state_.descriptor, place, reinterpret_cast<std::byte*>(found.data()),
                 found.size()))
      return false;
    if (std::string_view(found.data(), found.size()) == k_signature) return true;
  }
  return false;
}

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
