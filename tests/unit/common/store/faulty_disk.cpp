#include "tests/unit/common/store/faulty_disk.h"

#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <mutex>

#include "common/base/check.h"

namespace sleight::store::testing {
namespace {

constexpr std::uint64_t k_no_limit = std::numeric_limits<std::uint64_t>::max();

// SQLite calls plain functions, so their state is global.
std::atomic<std::uint64_t> good_calls_left{k_no_limit};
std::atomic<std::uint64_t> failed_calls{0};
std::atomic<std::uint64_t> failures_max{0};
std::atomic<int> failure_code{SQLITE_OK};
sqlite3_vfs* disk_behind = nullptr;
sqlite3_vfs faulty_disk;

/// File functions that can fail, and the real functions that they call.
struct FaultyMethods {
  sqlite3_io_methods faulty;
  const sqlite3_io_methods* real = nullptr;
};
std::array<FaultyMethods, 8> faulty_methods;  // the default disk has a set per kind of lock
std::mutex faulty_methods_mutex;

const sqlite3_io_methods& methods_behind(const sqlite3_file* file) {
  const auto found = std::find_if(
      faulty_methods.begin(), faulty_methods.end(),
      [&](const FaultyMethods& candidate) { return &candidate.faulty == file->pMethods; });
  CHECK(found != faulty_methods.end());
  return *found->real;
}

bool fails() {
  std::uint64_t left = good_calls_left.load();
  while (left != k_no_limit && left > 0) {
    if (good_calls_left.compare_exchange_weak(left, left - 1)) return false;
  }
  if (left == k_no_limit || failed_calls.load() >= failures_max.load()) return false;
  ++failed_calls;
  return true;
}

int faulty_write(sqlite3_file* file, const void* data, int size, sqlite3_int64 at) {
  return fails() ? failure_code.load() : methods_behind(file).xWrite(file, data, size, at);
}

int faulty_truncate(sqlite3_file* file, sqlite3_int64 size) {
  return fails() ? failure_code.load() : methods_behind(file).xTruncate(file, size);
}

int faulty_sync(sqlite3_file* file, int flags) {
  return fails() ? failure_code.load() : methods_behind(file).xSync(file, flags);
}

int faulty_open(sqlite3_vfs*, const char* name, sqlite3_file* file, int flags, int* out_flags) {
  const int code = disk_behind->xOpen(disk_behind, name, file, flags, out_flags);
  if (code != SQLITE_OK) return code;
  const std::scoped_lock lock(faulty_methods_mutex);
  const auto entry = std::find_if(
      faulty_methods.begin(), faulty_methods.end(), [&](const FaultyMethods& candidate) {
        return candidate.real == file->pMethods || candidate.real == nullptr;
      });
  CHECK(entry != faulty_methods.end());
  if (entry->real == nullptr) {
    entry->faulty = *file->pMethods;
    entry->faulty.xWrite = &faulty_write;
    entry->faulty.xTruncate = &faulty_truncate;
    entry->faulty.xSync = &faulty_sync;
    entry->real = file->pMethods;
  }
  file->pMethods = &entry->faulty;
  return SQLITE_OK;
}

}  // namespace

FaultyDisk::FaultyDisk() {
  repair();
  disk_behind = sqlite3_vfs_find(nullptr);
  faulty_disk = *disk_behind;
  faulty_disk.zName = "faulty";
  faulty_disk.pNext = nullptr;
  faulty_disk.xOpen = &faulty_open;
  CHECK(sqlite3_vfs_register(&faulty_disk, 1) == SQLITE_OK);
}

FaultyDisk::~FaultyDisk() {
  sqlite3_vfs_unregister(&faulty_disk);
  sqlite3_vfs_register(disk_behind, 1);
}

void FaultyDisk::fail_after(std::uint64_t calls, int code, std::uint64_t times) {
  failed_calls = 0;
  failures_max = times;
  failure_code = code;
  good_calls_left = calls;
}

void FaultyDisk::repair() {
  good_calls_left = k_no_limit;
}

std::uint64_t FaultyDisk::failures() const {
  return failed_calls.load();
}

}  // namespace sleight::store::testing
