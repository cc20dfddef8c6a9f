// An interface of the file operations on which durability depends. Tests can make any of them fail.
//
// Callers rely on this sequence: write a temporary file, then call sync_file, rename and
// sync_directory. After a crash or power loss, the renamed file is complete or absent.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"

namespace sleight::base {

/// A file open for reading and writing at any position. All functions of `File` return the system's
/// error code instead of throwing, because a C library calls them (archive/hdf5). Not thread-safe.
class File {
 public:
  virtual ~File() = default;  ///< closes the file, ignoring errors
  /// Writes all of `bytes`, or returns an error. After an error, a part may have been written.
  virtual std::error_code write_at(std::uint64_t offset, BytesView bytes) = 0;
  /// Fills `bytes`, using zeros beyond the file's end and after errors.
  virtual std::error_code read_at(std::uint64_t offset, std::span<std::byte> bytes) = 0;
  virtual std::error_code resize(std::uint64_t size) = 0;
  /// On a network file system a write may fail only here. REQUIRES: last call.
  virtual std::error_code close() = 0;
};

/// Every function except create throws base::Error with the path and the system's reason.
class FileSystem {
 public:
  virtual ~FileSystem() = default;
  virtual bool exists(const std::string& path) const = 0;
  /// Returns false if the path does not exist.
  virtual bool is_directory(const std::string& path) const = 0;
  /// Returns the sorted names in a folder.
  virtual std::vector<std::string> names_in(const std::string& folder) const = 0;
  /// Creates or empties a file, but does not follow a link. Returns the system's error code,
  /// because callers word the message.
  virtual Result<std::unique_ptr<File>, std::error_code> create(const std::string& path) = 0;
  virtual void sync_file(const std::string& path) = 0;
  /// Syncs the folder that contains `path`, which makes a rename or a new name durable.
  virtual void sync_directory_of(const std::string& path) = 0;
  /// Replaces `to` atomically.
  virtual void rename(const std::string& from, const std::string& to) = 0;
  /// A missing file is not an error.
  virtual void remove(const std::string& path) = 0;
  /// An existing folder is not an error.
  virtual void make_folder(const std::string& path) = 0;
};

class PosixFileSystem final : public FileSystem {
 public:
  bool exists(const std::string& path) const override;
  bool is_directory(const std::string& path) const override;
  std::vector<std::string> names_in(const std::string& folder) const override;
  Result<std::unique_ptr<File>, std::error_code> create(const std::string& path) override;
  void sync_file(const std::string& path) override;
  void sync_directory_of(const std::string& path) override;
  void rename(const std::string& from, const std::string& to) override;
  void remove(const std::string& path) override;
  void make_folder(const std::string& path) override;
};

/// Returns the folder part of a path, or "." if the path has no folder.
std::string directory_of(const std::string& path);

/// Creates or overwrites a file, neither atomically nor durably. Throws base::Error.
void write_text_file(FileSystem& files, const std::string& path, std::string_view text);

/// Reads a text file. Throws base::Error if the file can't be read or exceeds `bytes_max`.
std::string read_text_file(const std::string& path, std::size_t bytes_max);
/// Reads standard input to its end. Throws as read_text_file does.
std::string read_standard_input(std::size_t bytes_max);

}  // namespace sleight::base
