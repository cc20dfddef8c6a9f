#include "clients/gallery_server/listed_files.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

namespace sleight::gallery {
namespace {

namespace fs = std::filesystem;

constexpr const char* k_ending = ".h5";

/// Whether a folder's file is really in the folder, after following links.
bool lies_in(const fs::path& file, const fs::path& folder) {
  std::error_code failure;
  const fs::path real = fs::canonical(file, failure);
  if (failure) return false;
  const fs::path real_folder = fs::canonical(folder, failure);
  return !failure && real.parent_path() == real_folder;
}

}  // namespace

ListedFiles listed_files(const std::vector<std::string>& paths) {
  ListedFiles listed;
  for (const std::string& path : paths) {
    std::error_code failure;
    if (!fs::is_directory(path, failure)) {
      listed.files.push_back({.path = path, .name = fs::path(path).filename().string()});
      continue;
    }
    std::vector<fs::path> inside;
    for (fs::directory_iterator item(path, failure), end; !failure && item != end;
         item.increment(failure)) {
      if (item->path().extension() == k_ending) inside.push_back(item->path());
    }
    if (failure) listed.left_out.push_back({.name = path, .reason = failure.message()});
    std::ranges::sort(inside);
    for (const fs::path& file : inside) {
      const std::string name = file.filename().string();
      if (lies_in(file, path)) {
        listed.files.push_back({.path = file.string(), .name = name});
      } else {
        listed.left_out.push_back(
            {.name = name, .reason = "a link that points outside the folder"});
      }
    }
  }
  return listed;
}

}  // namespace sleight::gallery
