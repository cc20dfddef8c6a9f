#include "clients/browse/archives/index_cache.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

#include "clients/browse/index_bytes.h"
#include "common/base/cores.h"
#include "common/base/own_folder.h"
#include "common/base/version.h"
#include "common/hash/sha256.h"

namespace sleight::browse {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t k_name_letters = 32;

std::optional<fs::path> cache_place(const std::string& archive, std::string_view ending) {
  const auto folder = base::own_folder("XDG_CACHE_HOME", ".cache", "browse");
  std::error_code failure;
  const fs::path real = fs::canonical(archive, failure);
  if (!folder || failure) return std::nullopt;
  return *folder /
         (hash::sha256_hex(real.string()).substr(0, k_name_letters) + std::string(ending));
}

/// Marks unfinished files. An unfinished file older than this was left by a killed program.
constexpr const char* k_unfinished = ".tmp.";
constexpr auto k_left_behind = std::chrono::hours(1);

/// Deletes leftover files, then the least recently used files until this many bytes fit.
void make_room(const fs::path& folder, std::uint64_t bytes) {
  struct Kept {
    fs::file_time_type used;
    fs::path path;
    std::uint64_t bytes;
  };
  std::vector<Kept> kept;
  std::error_code failure;
  std::uint64_t total = bytes;
  for (fs::directory_iterator it(folder, failure), end; !failure && it != end;
       it.increment(failure)) {
    std::error_code unknown;
    const std::uint64_t size = it->file_size(unknown);
    const auto used = it->last_write_time(unknown);
    if (unknown) continue;
    const std::string name = it->path().filename().string();
    if (name.find(k_unfinished) != std::string::npos &&
        used < fs::file_time_type::clock::now() - k_left_behind)
      fs::remove(it->path(), unknown);
    const fs::path ending = it->path().extension();
    if (ending != k_index_ending && ending != k_outline_ending) continue;
    kept.push_back({.used = used, .path = it->path(), .bytes = size});
    total += size;
  }
  std::ranges::sort(kept, {}, &Kept::used);
  for (const Kept& old : kept) {
    if (total <= k_cache_bytes_max) return;
    fs::remove(old.path, failure);
    total -= old.bytes;
  }
}

/// Writes the state and the content to a new file beside the cache file. Returns an empty path on
/// failure.
std::string write_beside(const fs::path& place, const FileState& of, base::BytesView content) {
  std::string path = place.string() + ".tmp.XXXXXX";
  const int file = ::mkstemp(path.data());
  if (file < 0) return {};
  bool is_written = true;
  for (base::BytesView left : {base::BytesView(std::as_bytes(std::span(&of, 1))), content}) {
    while (is_written && !left.empty()) {
      const ssize_t put = ::write(file, left.data(), left.size());
      if (put < 0 && errno == EINTR) continue;
      is_written = put > 0;
      if (is_written) left = left.subspan(static_cast<std::size_t>(put));
    }
  }
  is_written = ::close(file) == 0 && is_written;
  if (is_written) return path;
  ::unlink(path.c_str());
  return {};
}

bool is_worth_keeping(const browse::Index& index) {
  std::size_t pieces = 0;
  for (const browse::Entry& entry : index.entries)
    pieces += entry.pieces.size();
  return pieces >= k_pieces_worth_keeping;
}

}  // namespace

std::optional<FileState> state_of_file(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return std::nullopt;
  const auto ns = [](const timespec& time) {
    constexpr std::int64_t k_ns_per_s = 1'000'000'000;
    return k_ns_per_s * time.tv_sec + time.tv_nsec;
  };
  return FileState{.size = static_cast<std::uint64_t>(status.st_size),
                   .device = status.st_dev,
                   .inode = status.st_ino,
                   .modified_ns = ns(status.st_mtim),
                   .changed_ns = ns(status.st_ctim)};
}

std::optional<CachedBytes> cached(const std::string& archive, std::string_view ending) {
  const auto place = cache_place(archive, ending);
  if (!place) return std::nullopt;
  std::error_code failure;
  if (!fs::is_regular_file(*place, failure)) return std::nullopt;  // reading a pipe would block
  std::ifstream file(*place, std::ios::binary);
  const std::uint64_t size = fs::file_size(*place, failure);
  CachedBytes found;
  if (!file || failure || size < sizeof(found.of) || size > k_cache_bytes_max) return std::nullopt;
  if (!file.read(reinterpret_cast<char*>(&found.of), sizeof(found.of))) return std::nullopt;
  found.size = size - sizeof(found.of);
  // Don't zero the memory: an index can have hundreds of megabytes.
  found.bytes = std::make_unique_for_overwrite<std::byte[]>(found.size);
  if (!file.read(reinterpret_cast<char*>(found.bytes.get()),
                 static_cast<std::streamsize>(found.size)))
    return std::nullopt;
  fs::last_write_time(*place, fs::file_time_type::clock::now(), failure);
  return found;
}

void keep_cached(const std::string& archive, std::string_view ending, const FileState& of,
                 base::BytesView content) {
  const auto place = cache_place(archive, ending);
  if (!place || content.size() > k_cache_bytes_max) return;
  std::error_code failure;
  fs::create_directories(place->parent_path(), failure);
  if (failure) return;
  // The folder is private, because it shows what its owner browses.
  fs::permissions(place->parent_path(), fs::perms::owner_all, failure);
  make_room(place->parent_path(), content.size());
  const std::string beside = write_beside(*place, of, content);
  if (beside.empty()) return;
  fs::rename(beside, *place, failure);
  if (failure) fs::remove(beside, failure);
}

std::optional<KeptIndex> kept_index(const std::string& archive) {
  const auto bytes = cached(archive, k_index_ending);
  if (!bytes) return std::nullopt;
  auto index = browse::index_of(bytes->content(), base::cores_here());
  if (!index) return std::nullopt;
  return KeptIndex{.index = *std::move(index), .of = bytes->of};
}

void keep_index(const std::string& archive, const FileState& of, const browse::Index& index) {
  if (is_worth_keeping(index)) keep_cached(archive, k_index_ending, of, browse::bytes_of(index));
}

std::optional<browse::Outline> kept_outline(const std::string& archive, const FileState& of) {
  const auto bytes = cached(archive, k_outline_ending);
  if (!bytes || !(bytes->of == of)) return std::nullopt;
  return browse::outline_of_bytes(bytes->content(), base::version());
}

void keep_outline(const std::string& archive, const FileState& of, const browse::Index& index,
                  const browse::Groups& groups) {
  if (!is_worth_keeping(index)) return;
  keep_cached(archive, k_outline_ending, of,
              browse::bytes_of(browse::outline_of(index, groups), base::version()));
}

}  // namespace sleight::browse
