// The file that HDF5 writes an archive into, as an HDF5 file driver that never fails half-way.
//
// When a write fails (a full disk), HDF5 1.10.8 can neither close the file nor forget it: objects
// stay open for the life of the process, and closing again crashes (both seen). So the driver keeps
// the first failure to itself and goes on as if all were well; HDF5 closes cleanly, and the writer
// then asks for the failure and drops the file. After a failure nothing more is written.
//
// Not thread-safe.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <memory>
#include <string>
#include <system_error>

#include "common/base/file_system.h"

namespace sleight::archive::hdf5 {

class OutputFile {
 public:
  /// Creates `path`, or empties it. Throws base::Error naming the path and the system's reason.
  OutputFile(std::string path, base::FileSystem& file_system);
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Makes H5Fcreate with this file-access list write here, whatever name it is given.
  /// Negative on failure, as HDF5 has it. The list may be used once, while this object lives.
  herr_t use_in(hid_t file_access_list);

  /// Throws base::Error with the first failure of a read or write since the creation, if any.
  void throw_failure() const;

  /// Closes the file, which on a network file system may be when a write fails. Throws like
  /// throw_failure. REQUIRES: HDF5 has closed it.
  void close();

  /// What the driver's functions work on.
  struct State {
    std::unique_ptr<base::File> file;
    std::uint64_t allocated = 0;  ///< HDF5's end of allocation
    std::uint64_t written = 0;    ///< end of what was written, as far as HDF5 knows
    std::error_code failure{};    ///< the first one
  };

 private:
  std::string path_;
  State state_;
};

}  // namespace sleight::archive::hdf5
