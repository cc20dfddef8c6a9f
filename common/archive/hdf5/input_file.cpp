#include "common/archive/hdf5/input_file.h"

#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <string_view>

#include "common/archive/hdf5/driver.h"

namespace sleight::archive::hdf5 {
namespace {

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

}  // namespace

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

}  // namespace sleight::archive::hdf5
