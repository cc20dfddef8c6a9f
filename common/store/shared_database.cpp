#include "common/store/shared_database.h"

#include <fmt/format.h>

#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include "common/base/error.h"
#include "common/base/file_system.h"
#include "common/base/network_disk.h"
#include "common/store/run_store.h"
#include "common/store/take_over.h"

namespace sleight::store {
namespace {

constexpr std::string_view k_folder_ending = ".run";

/// Throws an error for a store on a network disk: why the store can't be read now, and what to read
/// instead.
[[noreturn]] void refuse_to_read(const std::string& folder, const std::string& disk,
                                 const std::string& reason) {
  const std::string own = own_archive_of(folder);
  const bool has_archive = !own.empty() && base::PosixFileSystem().exists(own);
  throw base::Error(
      base::ExitCode::conflict,
      fmt::format("{}: on a network disk ({}), only the process that writes a run can read its "
                  "store; {}wait until no process writes the run ({})",
                  folder, disk,
                  has_archive ? fmt::format("use the latest archive, {}, or ", own) : std::string(),
                  reason));
}

}  // namespace

SharedDatabase::SharedDatabase(const std::string& path, Access access) : database_(path, access) {}

SharedDatabase::SharedDatabase(std::unique_ptr<RunLock> lock, const std::string& path,
                               Access access)
    : lock_(std::move(lock)), database_(path, access) {}

SharedDatabase::Turn::Turn(SharedDatabase& shared) : shared_(shared) {
  std::unique_lock lock(shared.mutex_);
  const std::uint64_t mine = shared.asked_++;
  shared.changed_.wait(lock, [&] { return shared.served_ == mine; });
}

SharedDatabase::Turn::~Turn() {
  {
    const std::scoped_lock lock(shared_.mutex_);
    ++shared_.served_;
  }
  shared_.changed_.notify_all();
}

std::shared_ptr<SharedDatabase> open_to_read(const std::string& folder) {
  const std::string path = RunStore::database_path(folder);
  const auto disk = base::network_file_system(folder);
  if (!disk || !base::PosixFileSystem().exists(path))
    return std::make_shared<SharedDatabase>(path, Access::read_only);

  // Hold the run's lock while reading. SQLite may have to recover the log, which requires writing.
  std::unique_ptr<RunLock> lock;
  try {
    lock = std::make_unique<RunLock>(folder, RunLockOptions{.waits = false});
  } catch (const base::Error& failure) {
    refuse_to_read(folder, *disk, failure.what());
  }
  if (lock->owes_copies()) replace_files_of_run(folder, *lock);
  lock->keep();
  return std::make_shared<SharedDatabase>(std::move(lock), path, Access::read_write);
}

std::string own_archive_of(const std::string& folder) {
  std::error_code ignored;
  const std::string whole = std::filesystem::canonical(folder, ignored).string();
  return whole.ends_with(k_folder_ending) ? whole.substr(0, whole.size() - k_folder_ending.size())
                                          : std::string();
}

}  // namespace sleight::store
