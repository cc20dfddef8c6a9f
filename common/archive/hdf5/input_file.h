// The file that HDF5 reads an archive from, as an HDF5 file driver over a file that is already
// open.
//
// HDF5's own driver opens files by name. A process that has given up the right to open any
// (archive/reader_program) has its archive open already, and reads it through this one.
//
// Not thread-safe.
#pragma once

#include <hdf5.h>

#include <cstdint>

namespace sleight::archive::hdf5 {

class InputFile {
 public:
  /// Takes `descriptor` over and closes it. `bytes`: the length of the file.
  InputFile(int descriptor, std::uint64_t bytes) : state_{descriptor, bytes, 0} {}
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  ~InputFile();

  /// Makes H5Fopen with this file-access list read from here, whatever name it is given. Negative
  /// on failure, as HDF5 has it. The list may be used once, while this object lives.
  herr_t use_in(hid_t file_access_list);

  /// Whether HDF5's signature is at one of the places where it may be.
  bool has_signature() const;

  /// What the driver's functions work on.
  struct State {
    int descriptor = -1;
    std::uint64_t bytes = 0;
    std::uint64_t allocated = 0;  ///< HDF5's end of allocation
  };

 private:
  State state_;
};

}  // namespace sleight::archive::hdf5
