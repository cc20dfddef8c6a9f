// The real file system, except that chosen calls fail.
//
// A FaultyFileSystem counts the calls of all its files. Not thread-safe.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "common/base/file_system.h"

namespace sleight::base::testing {

enum class FileCall {
  look,  ///< exists, is_directory
  list,
  create,
  read,
  write,
  resize,
  close,
  sync_file,
  sync_directory,
  rename,
  remove,
  make_folder
};

std::string name_of(FileCall call);

struct Fault {
  static constexpr std::uint64_t k_for_ever = std::numeric_limits<std::uint64_t>::max();

  std::optional<FileCall> call{};  ///< calls of this kind are counted and fail; none: all kinds
  std::uint64_t after = 0;         ///< calls that succeed before the first failure
  std::uint64_t times = k_for_ever;
  std::errc reason{};
};

class FaultyFileSystem final : public FileSystem {
 public:
  /// Sets the fault and starts counting calls for it.
  void fail(const Fault& fault);
  std::uint64_t failures() const { return failures_; }

  bool exists(const std::string& path) const override;
  bool is_directory(const std::string& path) const override;
  std::vector<std::string> names_in(const std::string& folder) const override;
  /// The file must not outlive this object. If a write fails, it still writes half of its bytes.
  Result<std::unique_ptr<File>, std::error_code> create(const std::string& path) override;
  void sync_file(const std::string& path) override;
  void sync_directory_of(const std::string& path) override;
  void rename(const std::string& from, const std::string& to) override;
  void remove(const std::string& path) override;
  void make_folder(const std::string& path) override;

  /// Returns the error with which the call fails, or no error if the call succeeds.
  std::error_code failure_of(FileCall call) const;

 private:
  void throw_failure_of(FileCall call, const std::string& path) const;

  std::optional<Fault> fault_;
  mutable std::uint64_t calls_ = 0;
  mutable std::uint64_t failures_ = 0;
  PosixFileSystem real_;
};

}  // namespace sleight::base::testing
