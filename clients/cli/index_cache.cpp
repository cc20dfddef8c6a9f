#include "clients/cli/index_cache.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "clients/browse/index_bytes.h"
#include "common/hash/sha256.h"

namespace sleight::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t k_name_letters = 32;
constexpr const char* k_ending = ".index";

/// By the XDG base directory specification, where a relative path does not count.
std::optional<fs::path> cache_folder() {
  const char* given = std::getenv("XDG_CACHE_HOME");
  if (given != nullptr && given[0] == '/') return fs::path(given) / "sleight" / "browse";
  const char* home = std::getenv("HOME");
  if (home != nullptr && home[0] == '/') return fs::path(home) / ".cache" / "sleight" / "browse";
  return std::nullopt;
}

std::optional<fs::path> place_of(const std::string& archive) {
  const auto folder = cache_folder();
  std::error_code failure;
  const fs::path real = fs::canonical(archive, failure);
  if (!folder || failure) return std::nullopt;
  return *folder / (hash::sha256_hex(real.string()).substr(0, k_name_letters) + k_ending);
}

/// Deletes what was used longest ago, until there is room for so many bytes more.
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
    if (unknown || it->path().extension() != k_ending) continue;
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

}  // namespace

std::optional<browse::Index> kept_index(const std::string& archive) {
  const auto place = place_of(archive);
  if (!place) return std::nullopt;
  std::ifstream file(*place, std::ios::binary);
  std::error_code failure;
  const std::uint64_t size = fs::file_size(*place, failure);
  if (!file || failure || size > k_cache_bytes_max) return std::nullopt;
  base::Bytes bytes(size);
  if (!file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size)))
    return std::nullopt;
  fs::last_write_time(*place, fs::file_time_type::clock::now(), failure);
  return browse::index_of(bytes);
}

void keep_index(const std::string& archive, const browse::Index& index) {
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
  const fs::path beside = place->string() + fmt::format(".{}", ::getpid());
  {
    const mode_t mask = ::umask(0077);
    std::ofstream file(beside, std::ios::binary);
    ::umask(mask);
    file.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!file) {
      fs::remove(beside, failure);
      return;
    }
  }
  fs::rename(beside, *place, failure);
  if (failure) fs::remove(beside, failure);
}

}  // namespace sleight::cli
