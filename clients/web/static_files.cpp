#include "clients/web/static_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

#include "clients/web/gzip.h"
#include "common/base/descriptor.h"
#include "common/base/error.h"
#include "common/base/file_system.h"
#include "common/hash/sha256.h"

namespace sleight::web {
namespace {

struct Type {
  std::string_view extension;
  std::string_view type;
  bool is_packed;  ///< already compressed
};
constexpr std::array<Type, 8> k_types{{{".html", "text/html; charset=utf-8", false},
                                       {".js", "text/javascript; charset=utf-8", false},
                                       {".css", "text/css; charset=utf-8", false},
                                       {".svg", "image/svg+xml", false},
                                       {".png", "image/png", true},
                                       {".wasm", "application/wasm", false},
                                       {".json", "application/json", false},
                                       {".woff2", "font/woff2", true}}};

const Type* type_entry(std::string_view name) {
  const auto found = std::ranges::find_if(
      k_types, [&](const Type& type) { return name.ends_with(type.extension); });
  return found == k_types.end() ? nullptr : &*found;
}

[[noreturn]] void fail(const std::string& path, const std::string& words) {
  throw base::Error(fmt::format("{}: {}", path, words));
}
[[noreturn]] void fail_as_system_says(const std::string& path) {
  fail(path, std::generic_category().message(errno));
}

std::string read_all(const base::Descriptor& file, const std::string& path, std::size_t size) {
  // Reads one byte more than expected, to detect a growing file.
  std::string text(size + 1, '\0');
  std::size_t filled = 0;
  while (filled < text.size()) {
    const ssize_t count = ::read(file.get(), text.data() + filled, text.size() - filled);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail_as_system_says(path);
    if (count == 0) break;
    filled += static_cast<std::size_t>(count);
  }
  if (filled != size)
    fail(path, "the file changed while it was read; start again after the page is built");
  text.resize(size);
  return text;
}

/// Compresses with gzip. Returns none if compression saves less than a tenth.
std::optional<std::string> compress(const std::string& plain) {
  std::string packed = gzipped(plain);
  if (packed.size() > plain.size() - plain.size() / 10) return std::nullopt;
  return packed;
}

}  // namespace

/// State while a folder is read.
struct StaticFiles::Reading {
  std::map<std::string, File, std::less<>>& files;
  std::string root;
  std::size_t bytes = 0;
  std::size_t entries = 0;

  void read_folder(const base::Descriptor& folder, const std::string& inside, int depth);
  void read_entry(const base::Descriptor& folder, const std::string& name,
                  const std::string& inside, int depth);
};

void StaticFiles::Reading::read_folder(const base::Descriptor& folder, const std::string& inside,
                                       int depth) {
  if (depth > k_static_depth_max) fail(root + inside, "is nested too deeply for a page's folder");
  // List the folder by its descriptor, in case another process renames or replaces the folder.
  const base::PosixFileSystem system;
  for (const std::string& name : system.names_in(fmt::format("/proc/self/fd/{}", folder.get())))
    read_entry(folder, name, inside, depth);
}

void StaticFiles::Reading::read_entry(const base::Descriptor& folder, const std::string& name,
                                      const std::string& inside, int depth) {
  if (name.starts_with('.')) return;
  const std::string path = inside + "/" + name;
  if (++entries > k_static_files_max)
    fail(root,
         fmt::format("contains more than {} files, the maximum for a page", k_static_files_max));
  // Open without following links or waiting for the other end of a pipe.
  const base::Descriptor file(
      ::openat(folder.get(), name.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK));
  if (!file && errno == ELOOP)
    fail(root + path, "is a link; a page's folder may only contain files and folders");
  if (!file) fail_as_system_says(root + path);
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) fail_as_system_says(root + path);
  if (S_ISDIR(status.st_mode)) {
    read_folder(file, path, depth + 1);
  } else if (S_ISREG(status.st_mode)) {
    bytes += static_cast<std::size_t>(status.st_size);
    if (bytes > k_static_bytes_max)
      fail(root,
           fmt::format("contains more than {} bytes, the maximum for a page", k_static_bytes_max));
    if (type_entry(name) != nullptr) {
      File& read = files[path];
      const std::string text =
          read_all(file, root + path, static_cast<std::size_t>(status.st_size));
      const Type& type = *type_entry(name);
      read = {.type = std::string(type.type),
              .etag = fmt::format("\"{}\"", hash::sha256_hex(text).substr(0, 32)),
              .cache = has_hash(name) ? Cache::immutable : Cache::no_store,
              .plain = text};
      if (!type.is_packed)
        if (auto packed = compress(text)) read.compressed = Content(std::move(*packed));
    }
  } else {
    fail(root + path,
         "is neither a file nor a folder; a page's folder may only contain files and folders");
  }
}

StaticFiles::StaticFiles(const std::string& folder) {
  const base::Descriptor root(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!root) fail_as_system_says(folder);
  Reading reading{.files = files_, .root = folder};
  reading.read_folder(root, "", 0);
  if (!files_.contains("/index.html")) fail(folder, "has no index.html; build the page again");
}

std::optional<Answer> StaticFiles::find(std::string_view path, bool accepts_gzip) const {
  const auto found = files_.find(path == "/" ? "/index.html" : path);
  if (found == files_.end()) return std::nullopt;
  const File& file = found->second;
  Answer answer{.type = file.type, .content = file.plain, .cache = file.cache, .etag = file.etag};
  if (!file.compressed) return answer;
  answer.fields.push_back({"Vary", "Accept-Encoding"});
  if (!accepts_gzip) return answer;
  answer.content = *file.compressed;
  answer.fields.push_back({"Content-Encoding", "gzip"});
  // Compressed bytes need another etag.
  answer.etag.insert(answer.etag.size() - 1, "-gzip");
  return answer;
}

std::optional<std::string_view> type_of(std::string_view name) {
  const Type* type = type_entry(name);
  if (type == nullptr) return std::nullopt;
  return type->type;
}

bool has_hash(std::string_view name) {
  constexpr std::size_t k_hash = 8;
  const std::string_view stem = name.substr(0, name.rfind('.'));
  if (stem.size() <= k_hash + 1) return false;
  const char before = stem[stem.size() - k_hash - 1];
  if (before != '-' && before != '.') return false;
  bool is_mixed = false;
  for (const char c : stem.substr(stem.size() - k_hash)) {
    const bool tells = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z');
    if (!tells && !(c >= 'a' && c <= 'z') && c != '-' && c != '_') return false;
    is_mixed = is_mixed || tells;
  }
  return is_mixed;
}

}  // namespace sleight::web
