// An HDF5 file driver that writes an archive and hides write failures from HDF5.
//
// If a write fails (a full disk), HDF5 1.10.8 can neither close the file nor abandon it. HDF5's
// objects then stay open until the process ends, and a second attempt to close them crashes (both
// observed). So the driver records the first failure, writes nothing more and reports success. HDF5
// then closes cleanly, and the writer checks for the failure and removes the file.
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
  /// Creates or truncates `path`. Throws base::Error with the path and the system's reason.
  OutputFile(std::string path, base::FileSystem& file_system);
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Sets the driver in a file-access list. H5Fcreate with this list then writes this file and
  /// ignores the name. Returns a negative value on failure, like HDF5. The list may be used once,
  /// during this object's life.
  herr_t use_in(hid_t file_access_list);

  /// Throws base::Error if any read or write has failed; the error describes the first one.
  void throw_failure() const;

  /// Closes the file. On a network file system, close may report an earlier write's failure. Throws
  /// like throw_failure. REQUIRES: HDF5 has closed the file.
  void close();

  struct State {
    std::unique_ptr<base::File> file;
    std::uint64_t allocated = 0;  ///< HDF5's end of allocation
    std::uint64_t written = 0;    ///< end of the written bytes in HDF5's view
    std::error_code failure{};
  };

 private:
  std::string path_;
  State state_;
};

}  // namespace sleight::archive::hdf5
