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

constexpr std::uint64_t k_never = std::numeric_limits<std::uint64_t>::max();

// SQLite calls plain functions: what they know is here.
std::atomic<std::uint64_t> good_calls_left{k_never};
std::atomic<std::uint64_t> failed_calls{0};
std::atomic<std::uint64_t> failures_max{0};
std::atomic<int> failure_code{SQLITE_OK};
sqlite3_vfs* real_disk = nullptr;
sqlite3_vfs faulty_disk;

/// A set of file functions with our faults in it, and the set that it stands for.
struct Methods {
  sqlite3_io_methods faulty;
  const sqlite3_io_methods* real = nullptr;
};
std::array<Methods, 8> methods;  // the default disk has one set for each kind of lock
std::mutex methods_mutex;

const sqlite3_io_methods& real_methods(const sqlite3_file* file) {
  const auto found = std::find_if(methods.begin(), methods.end(), [&](const Methods& candidate) {
    return &candidate.faulty == file->pMethods;
  });
  CHECK(found != methods.end());
  return *found->real;
}

bool fails() {
  std::uint64_t left = good_calls_left.load();
  while (left != k_never && left > 0) {
    if (good_calls_left.compare_exchange_weak(left, left - 1)) return false;
  }
  if (left == k_never || failed_calls.load() >= failures_max.load()) return false;
  ++failed_calls;
  return true;
}

int write(sqlite3_file* file, const void* data, int size, sqlite3_int64 at) {
  return fails() ? failure_code.load() : real_methods(file).xWrite(file, data, size, at);
}

int truncate(sqlite3_file* file, sqlite3_int64 size) {
  return fails() ? failure_code.load() : real_methods(file).xTruncate(file, size);
}

int sync(sqlite3_file* file, int flags) {
  return fails() ? failure_code.load() : real_methods(file).xSync(file, flags);
}

int open(sqlite3_vfs*, const char* name, sqlite3_file* file, int flags, int* out_flags) {
  const int code = real_disk->xOpen(real_disk, name, file, flags, out_flags);
  if (code != SQLITE_OK) return code;
  const std::scoped_lock lock(methods_mutex);
  const auto entry = std::find_if(methods.begin(), methods.end(), [&](const Methods& candidate) {
    return candidate.real == file->pMethods || candidate.real == nullptr;
  });
  CHECK(entry != methods.end());
  if (entry->real == nullptr) {
    entry->faulty = *file->pMethods;
    entry->faulty.xWrite = &write;
    entry->faulty.xTruncate = &truncate;
    entry->faulty.xSync = &sync;
    entry->real = file->pMethods;
  }
  file->pMethods = &entry->faulty;
  return SQLITE_OK;
}

}  // namespace

FaultyDisk::FaultyDisk() {
  repair();
  real_disk = sqlite3_vfs_find(nullptr);
  faulty_disk = *real_disk;
  faulty_disk.zName = "faulty";
  faulty_disk.pNext = nullptr;
  faulty_disk.xOpen = &open;
  CHECK(sqlite3_vfs_register(&faulty_disk, 1) == SQLITE_OK);
}

FaultyDisk::~FaultyDisk() {
  sqlite3_vfs_unregister(&faulty_disk);
  sqlite3_vfs_register(real_disk, 1);
}

void FaultyDisk::fail_after(std::uint64_t calls, int code, std::uint64_t times) {
  failed_calls = 0;
  failures_max = times;
  failure_code = code;
  good_calls_left = calls;
}

void FaultyDisk::repair() {
  good_calls_left = k_never;
}

std::uint64_t FaultyDisk::failures() const {
  return failed_calls.load();
}

}  // namespace sleight::store::testing
