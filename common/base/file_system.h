// The operating system's file effects that durability rests on, behind one interface so that a
// test can make any of them fail.
//
// The promise that callers build on them: a file written beside its place, sync_file, rename,
// sync_directory, in this order, is found whole or not at all after a crash or loss of power.
#pragma once

#include <string>
#include <string_view>

namespace sleight::base {

/// Every function throws base::Error naming the path and the system's reason.
class FileSystem {
 public:
  virtual ~FileSystem() = default;
  virtual bool exists(const std::string& path) const = 0;
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
  /// Makes a file of this content, or replaces its content; not in one step, and not durable.
  virtual void write_file(const std::string& path, std::string_view content) = 0;
};

class PosixFileSystem final : public FileSystem {
 public:
  bool exists(const std::string& path) const override;
  void sync_file(const std::string& path) override;
  void sync_directory_of(const std::string& path) override;
  void rename(const std::string& from, const std::string& to) override;
  void remove(const std::string& path) override;
  void make_folder(const std::string& path) override;
  void write_file(const std::string& path, std::string_view content) override;
};

/// The folder part of a path, "." where there is none.
std::string directory_of(const std::string& path);

/// The whole of a text file. Throws base::Error when it can't be read or exceeds `bytes_max`.
std::string read_text_file(const std::string& path, std::size_t bytes_max);

}  // namespace sleight::base
