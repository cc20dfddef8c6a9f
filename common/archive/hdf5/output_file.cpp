#include "common/archive/hdf5/output_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <utility>

#include "common/archive/hdf5/driver.h"
#include "common/base/error.h"

namespace sleight::archive::hdf5 {
namespace {

using State = OutputFile::State;

herr_t query(const H5FD_t*, unsigned long* flags) {
  // Few large writes: HDF5 gathers metadata and small data before calling write.
  *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
           H5FD_FEAT_AGGREGATE_SMALLDATA | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
  return 0;
}

haddr_t get_eof(const H5FD_t* file, H5FD_mem_t) {
  return state_of<State>(file).written;
}

/// Reads bytes that were written. Bytes beyond the file's end are zeros. After a failed write,
/// reads only zeros, which are never used.
herr_t read_bytes(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t address, std::size_t size,
                  void* buffer) {
  State& state = state_of<State>(file);
  if (state.failure) {
    std::memset(buffer, 0, size);
  } else {
    state.failure = state.file->read_at(address, {static_cast<std::byte*>(buffer), size});
  }
  return 0;
}

herr_t write_bytes(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t address, std::size_t size,
                   const void* buffer) {
  State& state = state_of<State>(file);
  state.written = std::max<std::uint64_t>(state.written, address + size);
  if (!state.failure) {
    state.failure = state.file->write_at(address, {static_cast<const std::byte*>(buffer), size});
  }
  return 0;
}

/// Extends the file to the length allocated by HDF5.
herr_t truncate_file(H5FD_t* file, hid_t, hbool_t) {
  State& state = state_of<State>(file);
  if (state.written == state.allocated) return 0;
  if (!state.failure) state.failure = state.file->resize(state.allocated);
  state.written = state.allocated;
  return 0;
}

H5FD_class_t driver_class() {
  H5FD_class_t driver = driver_for<State>("sleight_output");
  driver.query = query;
  driver.get_eof = get_eof;
  driver.read = read_bytes;
  driver.write = write_bytes;
  driver.truncate = truncate_file;
  return driver;
}

}  // namespace

OutputFile::OutputFile(std::string path, base::FileSystem& file_system) : path_(std::move(path)) {
  auto created = file_system.create(path_);
  if (!created) {
    throw base::Error(fmt::format("{}: can't create: {}", path_, created.error().message()));
  }
  state_.file = std::move(created).value();
}

void OutputFile::close() {
  const std::error_code outcome = state_.file->close();
  if (!state_.failure) state_.failure = outcome;
  throw_failure();
}

herr_t OutputFile::use_in(hid_t file_access_list) {
  static const H5FD_class_t driver = driver_class();
  static const hid_t driver_id = H5FDregister(&driver);
  return use_driver(file_access_list, driver_id, state_);
}

void OutputFile::throw_failure() const {
  if (state_.failure) {
    throw base::Error(fmt::format("{}: can't write: {}", path_, state_.failure.message()));
  }
}

}  // namespace sleight::archive::hdf5
