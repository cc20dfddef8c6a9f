#include "common/base/file_system.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <optional>
#include <utility>

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

std::error_code last_error() {
  return {errno, std::system_category()};
}

std::optional<struct stat> status_of(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0) return status;
  if (errno == ENOENT || errno == ENOTDIR) return std::nullopt;
  fail("inspect", path);
}

class PosixFile final : public File {
 public:
  explicit PosixFile(int descriptor) : descriptor_(descriptor) {}
  PosixFile(const PosixFile&) = delete;
  PosixFile& operator=(const PosixFile&) = delete;
  ~PosixFile() override {
    if (descriptor_ >= 0) ::close(descriptor_);
  }

  std::error_code write_at(std::uint64_t offset, BytesView bytes) override {
    while (!bytes.empty()) {
      const ssize_t put =
          ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
      if (put < 0 && errno == EINTR) continue;
      if (put < 0) return last_error();
      // Treat a write of zero bytes as an error, because it would be retried forever.
      if (put == 0) return {ENOSPC, std::system_category()};
      bytes = bytes.subspan(static_cast<std::size_t>(put));
      offset += static_cast<std::uint64_t>(put);
    }
    return {};
  }

  std::error_code read_at(std::uint64_t offset, std::span<std::byte> bytes) override {
    std::error_code failure;
    while (!bytes.empty()) {
      const ssize_t got =
          ::pread(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) failure = last_error();
      if (got <= 0) break;
      bytes = bytes.subspan(static_cast<std::size_t>(got));
      offset += static_cast<std::uint64_t>(got);
    }
    std::ranges::fill(bytes, std::byte{0});
    return failure;
  }

  std::error_code resize(std::uint64_t size) override {
    return ::ftruncate(descriptor_, static_cast<off_t>(size)) == 0 ? std::error_code()
                                                                   : last_error();
  }

  std::error_code close() override {
    return ::close(std::exchange(descriptor_, -1)) == 0 ? std::error_code() : last_error();
  }

 private:
  int descriptor_;
};

}  // namespace

bool PosixFileSystem::exists(const std::string& path) const {
  return status_of(path).has_value();
}

bool PosixFileSystem::is_directory(const std::string& path) const {
  const auto status = status_of(path);
  return status && S_ISDIR(status->st_mode);
}

std::vector<std::string> PosixFileSystem::names_in(const std::string& folder) const {
  std::error_code failure;
  std::vector<std::string> names;
  std::filesystem::directory_iterator entry(folder, failure);
  while (!failure && entry != std::filesystem::directory_iterator()) {
    names.push_back(entry->path().filename().string());
    entry.increment(failure);
  }
  if (failure) throw Error(fmt::format("{}: can't list: {}", folder, failure.message()));
  std::ranges::sort(names);
  return names;
}

Result<std::unique_ptr<File>, std::error_code> PosixFileSystem::create(const std::string& path) {
  const int descriptor =
      ::open(path.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (descriptor < 0) return last_error();
  return std::unique_ptr<File>(std::make_unique<PosixFile>(descriptor));
}

void PosixFileSystem::sync_file(const std::string& path) {
  sync_path(path, O_RDONLY, "sync");
}

void PosixFileSystem::sync_directory_of(const std::string& path) {
  sync_path(directory_of(path), O_RDONLY | O_DIRECTORY, "sync the folder");
}

void PosixFileSystem::rename(const std::string& from, const std::string& to) {
  if (::rename(from.c_str(), to.c_str()) != 0) fail("move the new file here", to);
}

void PosixFileSystem::remove(const std::string& path) {
  if (::unlink(path.c_str()) != 0 && errno != ENOENT) fail("remove", path);
}

void PosixFileSystem::make_folder(const std::string& path) {
  if (::mkdir(path.c_str(), 0777) != 0 && errno != EEXIST) fail("create the folder", path);
}

std::string directory_of(const std::string& path) {
  const auto slash = path.find_last_of('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

void write_text_file(FileSystem& files, const std::string& path, std::string_view text) {
  const auto check = [&](const std::error_code& reason) {
    if (reason) throw Error(fmt::format("{}: can't write: {}", path, reason.message()));
  };
  auto created = files.create(path);
  if (!created) check(created.error());
  const std::unique_ptr<File> file = std::move(created).value();
  check(file->write_at(0, bytes_of(std::span<const char>(text.data(), text.size()))));
  check(file->close());
}

namespace {

std::string read_whole(std::FILE* file, const std::string& name, std::size_t bytes_max) {
  std::string text(bytes_max + 1, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file));
  if (std::ferror(file) != 0) fail("read", name);
  if (text.size() > bytes_max) {
    throw Error(fmt::format("{}: the file exceeds the limit of {} bytes", name, bytes_max));
  }
  return text;
}

}  // namespace

std::string read_text_file(const std::string& path, std::size_t bytes_max) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rbe"),
                                                             &std::fclose);
  if (!file) fail("open", path);
  return read_whole(file.get(), path, bytes_max);
}

std::string read_standard_input(std::size_t bytes_max) {
  return read_whole(stdin, "standard input", bytes_max);
}

}  // namespace sleight::base
