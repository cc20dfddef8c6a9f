// An HDF5 file driver that reads an archive from an open descriptor.
//
// HDF5's own driver opens files by name. The reader process (archive/reader_program) gives up the
// right to open files. So the process opens its archive before that, and reads the archive through
// this driver.
//
// Not thread-safe.
#pragma once

#include <hdf5.h>

#include <cstdint>

namespace sleight::archive::hdf5 {

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

}  // namespace sleight::archive::hdf5
