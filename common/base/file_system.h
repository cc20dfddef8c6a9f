// The operating system's file effects that durability rests on, behind one interface so that a
// test can make any of them fail.
//
// The promise that callers build on them: a file written beside its place, sync_file, rename,
// sync_directory, in this order, is found whole or not at all after a crash or loss of power.
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

/// A file open for reading and writing at any place. Its functions return the system's reason
/// instead of throwing it: a C library calls them (archive/hdf5). Not thread-safe.
class File {
 public:
  virtual ~File() = default;  ///< closes it, whatever comes of that
  /// Writes all of `bytes`, or says why not; then a part of them may be there.
  virtual std::error_code write_at(std::uint64_t offset, BytesView bytes) = 0;
  /// Fills `bytes`: with zeros beyond the end, and where it can't be read.
  virtual std::error_code read_at(std::uint64_t offset, std::span<std::byte> bytes) = 0;
  virtual std::error_code resize(std::uint64_t size) = 0;
  /// On a network file system a write may fail only here. REQUIRES: nothing is called after it.
  virtual std::error_code close() = 0;
};

/// Every function but create throws base::Error naming the path and the system's reason.
class FileSystem {
 public:
  virtual ~FileSystem() = default;
  virtual bool exists(const std::string& path) const = 0;
  /// False where there is nothing.
  virtual bool is_directory(const std::string& path) const = 0;
  /// Names of what lies in a folder, sorted.
  virtual std::vector<std::string> names_in(const std::string& folder) const = 0;
  /// Makes an empty file, also of one that is there, but not through a link. Returns the system's
  /// reason where it can't: callers know what to say of it.
  virtual Result<std::unique_ptr<File>, std::error_code> create(const std::string& path) = 0;
  /// fsync of a file's content.
  virtual void sync_file(const std::string& path) = 0;
  /// fsync of the folder that holds `path`: makes a rename or a new name durable.
  virtual void sync_directory_of(const std::string& path) = 0;
  /// Replaces `to` in one step.
  virtual void rename(const std::string& from, const std::string& to) = 0;
  /// No error when there is no such file.
  virtual void remove(const std::string& path) = 0;
  /// No error when it is there already.
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

/// The folder part of a path, "." where there is none.
std::string directory_of(const std::string& path);

/// Makes a file of this text, or replaces its content; not in one step, and not durable. Throws
/// base::Error.
void write_text_file(FileSystem& files, const std::string& path, std::string_view text);

/// The whole of a text file. Throws base::Error when it can't be read or exceeds `bytes_max`.
std::string read_text_file(const std::string& path, std::size_t bytes_max);
/// The same of standard input, to its end.
std::string read_standard_input(std::size_t bytes_max);

}  // namespace sleight::base
