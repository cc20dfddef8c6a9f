#include "clients/cli/index_cache.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <span>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "clients/browse/index_bytes.h"
#include "clients/cli/own_folder.h"
#include "common/hash/sha256.h"

namespace sleight::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t k_name_letters = 32;
constexpr const char* k_ending = ".index";

std::optional<fs::path> place_of(const std::string& archive) {
  const auto folder = own_folder("XDG_CACHE_HOME", ".cache", "browse");
  std::error_code failure;
  const fs::path real = fs::canonical(archive, failure);
  if (!folder || failure) return std::nullopt;
  return *folder / (hash::sha256_hex(real.string()).substr(0, k_name_letters) + k_ending);
}

/// Of a file that is being written; one that is this old was left by a program that was killed.
constexpr const char* k_unfinished = ".index.tmp";
constexpr auto k_left_behind = std::chrono::hours(1);

/// Deletes what was left behind, and what was used longest ago until there is room for so many
/// bytes more.
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
    if (it->path().extension() != k_ending) continue;
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

/// Writes both to a new file of its own beside the place; empty where that can't be done.
std::string write_beside(const fs::path& place, const FileState& of, base::BytesView index) {
  std::string path = place.string() + ".tmp.XXXXXX";
  const int file = ::mkstemp(path.data());
  if (file < 0) return {};
  bool is_written = true;
  for (base::BytesView left : {base::BytesView(std::as_bytes(std::span(&of, 1))), index}) {
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

std::optional<KeptIndex> kept_index(const std::string& archive) {
  const auto place = place_of(archive);
  if (!place) return std::nullopt;
  std::ifstream file(*place, std::ios::binary);
  std::error_code failure;
  const std::uint64_t size = fs::file_size(*place, failure);
  KeptIndex kept;
  if (!file || failure || size < sizeof(kept.of) || size > k_cache_bytes_max) return std::nullopt;
  // Not set to 0 before: it is hundreds of megabytes.
  const auto bytes = std::make_unique_for_overwrite<std::byte[]>(size);
  if (!file.read(reinterpret_cast<char*>(bytes.get()), static_cast<std::streamsize>(size)))
    return std::nullopt;
  std::memcpy(&kept.of, bytes.get(), sizeof(kept.of));
  auto index = browse::index_of(base::BytesView(bytes.get(), size).subspan(sizeof(kept.of)),
                                std::thread::hardware_concurrency());
  if (!index) return std::nullopt;
  kept.index = std::move(*index);
  fs::last_write_time(*place, fs::file_time_type::clock::now(), failure);
  return kept;
}

void keep_index(const std::string& archive, const FileState& of, const browse::Index& index) {
  std::size_t pieces = 0;
  for (const browse::Entry& entry : index.entries)
    pieces += entry.pieces.size();
  const auto place = place_of(archive);
  if (!place || pieces < k_pieces_worth_keeping) return;
  std::error_code failure;
  fs::create_directories(place->parent_path(), failure);
  if (failure) return;
  // What one browses is nobody else's.
  fs::permissions(place->parent_path(), fs::perms::owner_all, failure);
  const base::Bytes bytes = browse::bytes_of(index);
  if (bytes.size() > k_cache_bytes_max) return;
  make_room(place->parent_path(), bytes.size());
  const std::string beside = write_beside(*place, of, bytes);
  if (beside.empty()) return;
  fs::rename(beside, *place, failure);
  if (failure) fs::remove(beside, failure);
}

}  // namespace sleight::cli
