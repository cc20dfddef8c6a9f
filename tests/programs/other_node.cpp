// A library for LD_PRELOAD. Simulates another node of a cluster; SLEIGHT_TEST_HOST is the node's
// name. Every disk acts as NFS without a lock server: flock, fcntl locks and SQLite's shared-memory
// files don't work.
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/vfs.h>

#include <algorithm>
#include <cerrno>
#include <cstdarg>
#include <cstdlib>
#include <string>
#include <string_view>

namespace {

constexpr long k_nfs = 0x6969;

int refuse(int reason) {
  errno = reason;
  return -1;
}

int open_unshared(const char* function, const char* path, int flags, mode_t mode) {
  if (std::string_view(path).ends_with("-shm")) return refuse(EOPNOTSUPP);
  using Function = int(const char*, int, ...);
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, function))(path, flags, mode);
}

int control(const char* function, int descriptor, int command, void* argument) {
  if (command == F_GETLK || command == F_SETLK || command == F_SETLKW) return refuse(ENOLCK);
  using Function = int(int, int, ...);
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, function))(descriptor, command, argument);
}

}  // namespace

extern "C" {

int gethostname(char* name, size_t size) noexcept {
  const char* const said = std::getenv("SLEIGHT_TEST_HOST");
  const std::string host = said != nullptr ? said : "node";
  if (host.size() >= size) return refuse(ENAMETOOLONG);
  std::ranges::copy(host, name);
  name[host.size()] = '\0';
  return 0;
}

int statfs(const char* path, struct statfs* found) noexcept {
  using Function = int(const char*, struct statfs*);
  const int outcome = reinterpret_cast<Function*>(dlsym(RTLD_NEXT, "statfs"))(path, found);
  if (outcome == 0) found->f_type = k_nfs;
  return outcome;
}

// The function's C++ name differs from its C name, because fcntl.h declares a struct of that name.
int refused_flock(int descriptor, int operation) noexcept __asm__("flock");
int refused_flock(int, int) noexcept {
  return refuse(ENOSYS);
}

int open(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = va_arg(rest, mode_t);
  va_end(rest);
  return open_unshared("open", path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = va_arg(rest, mode_t);
  va_end(rest);
  return open_unshared("open64", path, flags, mode);
}

int fcntl(int descriptor, int command, ...) {
  va_list rest;
  va_start(rest, command);
  void* const argument = va_arg(rest, void*);
  va_end(rest);
  return control("fcntl", descriptor, command, argument);
}

int fcntl64(int descriptor, int command, ...) {
  va_list rest;
  va_start(rest, command);
  void* const argument = va_arg(rest, void*);
  va_end(rest);
  return control("fcntl64", descriptor, command, argument);
}
}
