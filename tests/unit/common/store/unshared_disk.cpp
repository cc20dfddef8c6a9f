#include "tests/unit/common/store/unshared_disk.h"

#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <limits>
#include <mutex>

#include "common/base/check.h"
#include "common/base/network_disk.h"

namespace sleight::store::testing {
namespace {

constexpr std::uint64_t k_never = std::numeric_limits<std::uint64_t>::max();

// SQLite calls plain functions, so their state is global.
std::atomic<std::uint64_t> calls_left{k_never};
sqlite3_vfs* real_disk = nullptr;
sqlite3_vfs unshared_disk;

/// File functions that offer no shared memory, and the real functions that they call.
struct Methods {
  sqlite3_io_methods unshared;
  const sqlite3_io_methods* real = nullptr;
};
std::array<Methods, 8> methods;  // the default disk has a set per kind of lock
std::mutex methods_mutex;

const sqlite3_io_methods& real_methods(const sqlite3_file* file) {
  const auto found = std::ranges::find_if(
      methods, [&](const Methods& candidate) { return &candidate.unshared == file->pMethods; });
  CHECK(found != methods.end());
  return *found->real;
}

void count() {
  const std::uint64_t left = calls_left.load();
  if (left == k_never) return;
  calls_left = left == 0 ? k_never : left - 1;
  if (left == 0) std::raise(SIGSTOP);
}

int write(sqlite3_file* file, const void* data, int size, sqlite3_int64 at) {
  count();
  return real_methods(file).xWrite(file, data, size, at);
}

int sync(sqlite3_file* file, int flags) {
  count();
  return real_methods(file).xSync(file, flags);
}

int open(sqlite3_vfs*, const char* name, sqlite3_file* file, int flags, int* out_flags) {
  const int code = real_disk->xOpen(real_disk, name, file, flags, out_flags);
  if (code != SQLITE_OK) return code;
  const std::scoped_lock lock(methods_mutex);
  const auto entry = std::ranges::find_if(methods, [&](const Methods& candidate) {
    return candidate.real == file->pMethods || candidate.real == nullptr;
  });
  CHECK(entry != methods.end());
  if (entry->real == nullptr) {
    entry->unshared = *file->pMethods;
    entry->unshared.iVersion = 1;  // version 1 has no shared memory, which version 2 added
    entry->unshared.xShmMap = nullptr;
    entry->unshared.xWrite = &write;
    entry->unshared.xSync = &sync;
    entry->real = file->pMethods;
  }
  file->pMethods = &entry->unshared;
  return SQLITE_OK;
}

}  // namespace

UnsharedDisk::UnsharedDisk() {
  real_disk = sqlite3_vfs_find(nullptr);
  unshared_disk = *real_disk;
  unshared_disk.zName = "unshared";
  unshared_disk.pNext = nullptr;
  unshared_disk.xOpen = &open;
  CHECK(sqlite3_vfs_register(&unshared_disk, 1) == SQLITE_OK);
  ::setenv(base::k_network_disk_variable, "1", 1);
}

UnsharedDisk::~UnsharedDisk() {
  ::unsetenv(base::k_network_disk_variable);
  sqlite3_vfs_unregister(&unshared_disk);
  sqlite3_vfs_register(real_disk, 1);
}

void UnsharedDisk::stop_after(std::uint64_t calls) {
  calls_left = calls;
}

}  // namespace sleight::store::testing
