#include "common/base/file_system.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include "common/base/error.h"

namespace sleight::base {
namespace {

[[noreturn]] void fail(const char* action, const std::string& path) {
  const int reason = errno;
  throw Error(fmt::format("{}: can't {}: {}", path, action, std::strerror(reason)));
}

void sync_path(const std::string& path, int flags, const char* action) {
  const int descriptor = ::open(path.c_str(), flags | O_CLOEXEC);
  if (descriptor < 0) fail(action, path);
  const int outcome = ::fsync(descriptor);
  const int reason = errno;
  ::close(descriptor);
  errno = reason;
  if (outcome != 0) fail(action, path);
}

}  // namespace

bool PosixFileSystem::exists(const std::string& path) const {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0) return true;
  if (errno == ENOENT || errno == ENOTDIR) return false;
  fail("look for it", path);
}

void PosixFileSystem::sync_file(const std::string& path) {
  sync_path(path, O_RDONLY, "sync it");
}

void PosixFileSystem::sync_directory_of(const std::string& path) {
  sync_path(directory_of(path), O_RDONLY | O_DIRECTORY, "sync the folder");
}

void PosixFileSystem::rename(const std::string& from, const std::string& to) {
  if (::rename(from.c_str(), to.c_str()) != 0) fail("put the new file in its place", to);
}

void PosixFileSystem::remove(const std::string& path) {
  if (::unlink(path.c_str()) != 0 && errno != ENOENT) fail("remove it", path);
}

void PosixFileSystem::make_folder(const std::string& path) {
  if (::mkdir(path.c_str(), 0777) != 0 && errno != EEXIST) fail("make the folder", path);
}

void PosixFileSystem::write_file(const std::string& path, std::string_view content) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "wbe"),
                                                             &std::fclose);
  if (!file) fail("write it", path);
  const bool written = std::fwrite(content.data(), 1, content.size(), file.get()) == content.size();
  // What is buffered is written here: closing alone would hide that the disk is full.
  if (!written || std::fflush(file.get()) != 0) fail("write it", path);
}

std::string directory_of(const std::string& path) {
  const auto slash = path.find_last_of('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

std::string read_text_file(const std::string& path, std::size_t bytes_max) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rbe"),
                                                             &std::fclose);
  if (!file) fail("open it", path);
  std::string text(bytes_max + 1, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file.get()));
  if (std::ferror(file.get()) != 0) fail("read it", path);
  if (text.size() > bytes_max) {
    throw Error(
        fmt::format("{}: larger than the {} bytes that such a file may have", path, bytes_max));
  }
  return text;
}

}  // namespace sleight::base
