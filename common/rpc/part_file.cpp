#include "common/rpc/part_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "common/base/error.h"
#include "common/base/file_system.h"
#include "common/base/output_beside.h"

namespace sleight::rpc {
namespace {

constexpr std::size_t k_digits_in_name = 16;
constexpr std::string_view k_part_end = ".part";

base::Error failed(const std::string& what, const std::string& path) {
  return base::Error(
      fmt::format("can't {} {}: {}", what, path, std::system_category().message(errno)));
}

std::string file_name_of(const std::string& path) {
  const auto slash = path.rfind('/');
  return slash == std::string::npos ? path : path.substr(slash + 1);
}

std::string part_of(const std::string& path, const std::string& sha256) {
  return fmt::format("{}/.{}.{}{}", base::directory_of(path), file_name_of(path),
                     sha256.substr(0, k_digits_in_name), k_part_end);
}

/// Returns the file's digest, or an empty string if the file can't be read.
std::string hash_of_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  hash::Sha256 hash;
  std::string piece(std::size_t{1} << 20U, '\0');
  while (file) {
    file.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    hash.update(std::string_view(piece).substr(0, static_cast<std::size_t>(file.gcount())));
  }
  return file.eof() ? hash::to_hex(hash.finish()) : std::string();
}

}  // namespace

PartFile::PartFile(const std::string& path, FileView view)
    : path_(base::where_links_lead(path)),
      part_(part_of(path_, view.sha256)),
      view_(std::move(view)) {
  descriptor_ = ::open(part_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (descriptor_ < 0) throw failed("write", part_);
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
    ::close(descriptor_);
    throw base::Error(base::ExitCode::conflict,
                      fmt::format("another process is fetching {}", path_));
  }
  // Hash the bytes that an earlier attempt wrote. Discard a part that is longer than the file: it
  // can't belong to this file.
  std::vector<std::byte> buffer(k_piece_bytes_max);
  while (true) {
    const auto got = ::pread(descriptor_, buffer.data(), buffer.size(), static_cast<off_t>(bytes_));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0 || bytes_ + static_cast<std::uint64_t>(got) > view_.size) {
      if (got != 0) {
        bytes_ = 0;
        hash_ = hash::Sha256();
      }
      break;
    }
    hash_.update(std::span(buffer.data(), static_cast<std::size_t>(got)));
    bytes_ += static_cast<std::uint64_t>(got);
  }
  if (::ftruncate(descriptor_, static_cast<off_t>(bytes_)) != 0) {
    const auto error = failed("write", part_);
    ::close(descriptor_);
    throw error;
  }
}

PartFile::~PartFile() {
  // Remove an empty part, which is useless to the next attempt.
  if (bytes_ == 0) ::unlink(part_.c_str());
  if (descriptor_ >= 0) ::close(descriptor_);
}

void PartFile::append(base::BytesView piece) {
  CHECK_LE(piece.size(), view_.size - bytes_);
  std::size_t done = 0;
  while (done < piece.size()) {
    const auto wrote = ::pwrite(descriptor_, piece.data() + done, piece.size() - done,
                                static_cast<off_t>(bytes_ + done));
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote <= 0) throw failed("write", part_);
    done += static_cast<std::size_t>(wrote);
  }
  hash_.update(piece);
  bytes_ += piece.size();
}

bool PartFile::finish(const FetchCheck& check, AtItsPlace other) {
  CHECK(is_whole());
  if (hash::to_hex(hash_.finish()) != view_.sha256) {
    ::unlink(part_.c_str());
    return false;
  }
  if (check) {
    try {
      check(part_);
    } catch (...) {
      ::unlink(part_.c_str());
      throw;
    }
  }
  if (::fsync(descriptor_) != 0) throw failed("write", part_);
  put_in_place(other);
  base::PosixFileSystem().sync_directory_of(path_);
  remove_other_parts();
  return true;
}

void PartFile::put_in_place(AtItsPlace other) {
  if (other == AtItsPlace::replaced) {
    base::PosixFileSystem().rename(part_, path_);
    return;
  }
  // Two actions must be one atomic step: checking that there is no other file, and renaming. If the
  // file system lacks RENAME_NOREPLACE, use link(), because link() is atomic too.
  if (::renameat2(AT_FDCWD, part_.c_str(), AT_FDCWD, path_.c_str(), RENAME_NOREPLACE) == 0) return;
  if (errno != EEXIST && ::link(part_.c_str(), path_.c_str()) == 0) {
    ::unlink(part_.c_str());
    return;
  }
  if (errno != EEXIST) throw failed("create", path_);
  const bool is_same = hash_of_file(path_) == view_.sha256;
  ::unlink(part_.c_str());
  if (is_same) return;
  throw base::Error(base::ExitCode::conflict,
                    fmt::format("{}: another file appeared there during the fetch; use --force to "
                                "replace it, or -o to choose another path",
                                path_));
}

// Skips parts that a process is writing.
void PartFile::remove_other_parts() const {
  const std::string folder = base::directory_of(path_);
  const std::string beginning = fmt::format(".{}.", file_name_of(path_));
  base::PosixFileSystem files;
  for (const std::string& name : files.names_in(folder)) {
    if (!name.starts_with(beginning) || !name.ends_with(k_part_end) ||
        name.size() != beginning.size() + k_digits_in_name + k_part_end.size())
      continue;
    const std::string part = fmt::format("{}/{}", folder, name);
    const int descriptor = ::open(part.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
    if (descriptor < 0) continue;
    if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0) ::unlink(part.c_str());
    ::close(descriptor);
  }
}

}  // namespace sleight::rpc
