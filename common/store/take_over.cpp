#include "common/store/take_over.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <span>
#include <system_error>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/error.h"
#include "common/base/file_system.h"
#include "common/logging/log.h"
#include "common/store/run_store.h"
#include "common/store/stored_motions.h"

namespace sleight::store {
namespace {

constexpr std::size_t k_piece_bytes = 4U << 20U;
constexpr const char* k_copy_ending = ".copy";

/// Copies a file to another name, durably.
void copy_file(const std::string& from, const std::string& to, base::FileSystem& files,
               RunLock& lock) {
  const auto failed = [&](const std::error_code& reason) {
    if (!reason) return;
    throw base::Error(
        fmt::format("{}: can't copy the run store of another machine, so can't take over the run: "
                    "{}; free disk space or check the disk, then run the same command again",
                    from, reason.message()));
  };
  std::error_code failure;
  const std::uintmax_t size = std::filesystem::file_size(from, failure);
  failed(failure);
  std::ifstream source(from, std::ios::binary);
  if (!source) failed(std::make_error_code(std::errc::io_error));
  auto target = files.create(to);
  if (!target) failed(target.error());
  std::vector<char> piece(k_piece_bytes);
  for (std::uint64_t at = 0; at < size; at += piece.size()) {
    const auto bytes = static_cast<std::size_t>(std::min<std::uint64_t>(piece.size(), size - at));
    // A short read is a failure: neither a database nor its log ever shrinks.
    if (!source.read(piece.data(), static_cast<std::streamsize>(bytes)))
      failed(std::make_error_code(std::errc::io_error));
    failed(
        target.value()->write_at(at, base::bytes_of(std::span<const char>(piece.data(), bytes))));
    lock.renew();
    lock.check();
  }
  failed(target.value()->close());
  files.sync_file(to);
}

}  // namespace

void replace_files_of_run(const std::string& folder, RunLock& lock) {
  base::PosixFileSystem files;
  const std::string database = RunStore::database_path(folder);
  // Copy the files in the order that take_over.h requires.
  const std::array<std::string, 2> names{database, database + "-wal"};
  if (files.exists(database)) {
    logging::info(
        fmt::format("{}: taking over the run of a process on another machine; copying the store "
                    "first, so that the old process can't change it",
                    folder));
    for (const std::string& name : names) {
      files.remove(name + k_copy_ending);
      if (files.exists(name)) copy_file(name, name + k_copy_ending, files, lock);
    }
    for (const std::string& name : names) {
      lock.check();
      if (files.exists(name + k_copy_ending)) files.rename(name + k_copy_ending, name);
    }
    files.sync_directory_of(database);
  }
  for (const char* suffix : {"", "-wal", "-shm"})
    files.remove(StoredMotions::path(folder) + suffix);
  lock.set_copied();
}

}  // namespace sleight::store
