#include "clients/gallery_server/saved_folder.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "common/base/check.h"
#include "common/base/error.h"
#include "common/base/file_system.h"
#include "common/base/output_beside.h"
#include "common/json/value.h"

namespace sleight::gallery {
namespace {

namespace fs = std::filesystem;
using Json = json::Value;

constexpr std::size_t k_manifest_bytes_max = 64U << 20U;
constexpr std::string_view k_work = ".sleight-saving-";

/// Whether a saved gallery may have a file of this name.
bool is_saved_name(const std::string& name) {
  if (name == "index.html" || name == "app.js" || name == "app.css" || name == k_manifest)
    return true;
  // Excludes "..", "." and doubled slashes, so that no name leads out of the folder.
  return name.starts_with("data/") && name.ends_with(".js") &&
         fs::path(name).lexically_normal().string() == name;
}

std::string manifest_of(const std::set<std::string>& names) {
  const Json json{{"about", "files that `sleight gallery --save` wrote and may replace"},
                  {"sleight_gallery", 1},
                  {"files", names}};
  return json.dump(1) + "\n";
}

/// The files in a folder's manifest; empty if the manifest is missing or isn't ours.
std::set<std::string> named_in_manifest(const fs::path& folder) {
  const fs::path path = folder / k_manifest;
  if (!fs::is_regular_file(fs::symlink_status(path))) return {};
  const Json json = Json::parse_or_null(base::read_text_file(path.string(), k_manifest_bytes_max));
  if (!json.is_object() || json.value("sleight_gallery", Json()) != 1) return {};
  const Json files = json.value("files", Json::array());
  if (!files.is_array()) return {};
  std::set<std::string> names;
  for (const Json& name : files.elements()) {
    if (!name.is_string() || !is_saved_name(name.get<std::string>())) return {};
    names.insert(name.get<std::string>());
  }
  return names.contains(std::string(k_manifest)) ? names : std::set<std::string>();
}

/// Whether one of the files is in this folder or a subfolder.
bool holds_some(const std::string& folder, const std::set<std::string>& names) {
  const auto next = names.lower_bound(folder + "/");
  return next != names.end() && next->starts_with(folder + "/");
}

/// Returns a folder's contents besides these files, sorted. A subfolder without such files counts
/// as one item.
std::vector<std::string> others_in(const fs::path& folder, const std::set<std::string>& names,
                                   const fs::path& work) {
  std::vector<std::string> others;
  for (fs::recursive_directory_iterator item(folder), end; item != end; ++item) {
    const std::string name = item->path().lexically_relative(folder).string();
    const fs::file_status status = item->symlink_status();
    if (fs::is_directory(status)) {
      if (holds_some(name, names)) continue;
      item.disable_recursion_pending();
      if (item->path() == work) continue;
    } else if (fs::is_regular_file(status) && names.contains(name)) {
      continue;
    }
    others.push_back(name);
  }
  std::ranges::sort(others);
  return others;
}

/// Returns the files that may be replaced. Throws base::Error if there are other files.
std::set<std::string> check_place(const fs::path& place, const fs::path& work) {
  if (!fs::is_directory(place)) {
    throw base::Error(
        base::ExitCode::conflict,
        fmt::format("{}: already exists and is not a folder; choose another name", place.string()));
  }
  std::set<std::string> names = named_in_manifest(place);
  const std::vector<std::string> others = others_in(place, names, work);
  if (others.empty()) return names;
  const std::string more =
      others.size() == 1 ? std::string() : fmt::format(" and {} more", others.size() - 1);
  const bool has_work =
      std::ranges::any_of(others, [](const auto& name) { return name.starts_with(k_work); });
  throw base::Error(
      base::ExitCode::conflict,
      fmt::format("{}: nothing was replaced, because the folder contains {}{}, which is not "
                  "part of a saved gallery; {}choose a new folder, or move the other files away",
                  place.string(), others.front(), more,
                  has_work ? fmt::format("a running or killed `--save` wrote {}...; ", k_work)
                           : std::string()));
}

/// Returns an absolute path with links followed and without a final slash.
fs::path resolved(const std::string& folder) {
  const fs::path place = fs::weakly_canonical(fs::absolute(base::where_links_lead(folder)));
  return place.has_filename() ? place : place.parent_path();
}

fs::path folder_of_our_own(const fs::path& parent) {
  std::string form = (parent / fmt::format("{}XXXXXX", k_work)).string();
  if (::mkdtemp(form.data()) == nullptr) {
    throw base::Error(fmt::format("{}: cannot create a folder in this folder: {}", parent.string(),
                                  std::generic_category().message(errno)));
  }
  return form;
}

/// Returns the first parts of the names, which are the folder's direct entries.
std::set<std::string> tops_of(const std::set<std::string>& names) {
  std::set<std::string> tops;
  for (const std::string& name : names)
    tops.insert(name.substr(0, name.find('/')));
  return tops;
}

/// Renames that can be undone.
class Moves {
 public:
  void move(const fs::path& from, const fs::path& to) {
    fs::rename(from, to);
    done_.emplace_back(from, to);
  }
  /// Undoes all renames. Returns false if a rename could not be undone.
  bool take_back() {
    bool is_whole = true;
    for (; !done_.empty(); done_.pop_back()) {
      std::error_code failure;
      fs::rename(done_.back().second, done_.back().first, failure);
      is_whole = is_whole && !failure;
    }
    return is_whole;
  }

 private:
  std::vector<std::pair<fs::path, fs::path>> done_;
};

}  // namespace

SavedFolder::SavedFolder(const std::string& folder)
    : place_(resolved(folder)), is_new_(!fs::exists(place_)) {
  if (is_new_) {
    fs::create_directories(place_.parent_path());
  } else {
    check_place(place_, {});
  }
  work_ = folder_of_our_own(is_new_ ? place_.parent_path() : place_);
  // A folder made by mkdtemp() is readable only by its owner, but this folder will be published.
  fs::create_directory(work_ / "new");
}

SavedFolder::~SavedFolder() {
  std::error_code failure;
  fs::remove_all(work_ / "new", failure);
  // These folders are removed only if empty, because they may contain the old gallery.
  fs::remove(work_ / "old", failure);
  fs::remove(work_, failure);
}

std::uint64_t SavedFolder::write(const std::string& name, std::string_view content) {
  CHECK(is_saved_name(name));
  const fs::path path = work_ / "new" / name;
  fs::create_directories(path.parent_path());
  base::PosixFileSystem files;
  base::write_text_file(files, path.string(), content);
  written_.insert(name);
  return content.size();
}

std::uint64_t SavedFolder::put_in_place() {
  written_.insert(std::string(k_manifest));
  const std::uint64_t bytes = write(std::string(k_manifest), manifest_of(written_));
  if (is_new_) {
    // The rename fails if anything but an empty folder has appeared there.
    fs::rename(work_ / "new", place_);
  } else {
    exchange();
  }
  return bytes;
}

void SavedFolder::exchange() {
  // Check the folder again, because it may have changed during writing.
  replaced_ = check_place(place_, work_);
  fs::create_directory(work_ / "old");
  Moves moves;
  try {
    for (const std::string& name : tops_of(replaced_)) {
      if (fs::exists(fs::symlink_status(place_ / name)))
        moves.move(place_ / name, work_ / "old" / name);
    }
    for (const std::string& name : tops_of(written_))
      moves.move(work_ / "new" / name, place_ / name);
  } catch (const fs::filesystem_error& error) {
    if (moves.take_back()) throw;
    throw base::Error(fmt::format("{}: {}; files of the old gallery are in {}", place_.string(),
                                  error.code().message(), (work_ / "old").string()));
  }
  remove_old();
}

void SavedFolder::remove_old() {
  std::error_code failure;
  std::set<fs::path> folders;
  for (const std::string& name : replaced_) {
    fs::remove(work_ / "old" / name, failure);
    for (fs::path folder = fs::path(name).parent_path(); !folder.empty();
         folder = folder.parent_path())
      folders.insert(folder);
  }
  // Reverse order removes subfolders first. Folders that aren't empty stay.
  for (auto folder = folders.rbegin(); folder != folders.rend(); ++folder)
    fs::remove(work_ / "old" / *folder, failure);
  fs::remove(work_ / "old", failure);
  if (!fs::exists(work_ / "old")) return;
  throw base::Error(base::ExitCode::conflict,
                    fmt::format("{}: the gallery was saved, but meanwhile files were added to the "
                                "old gallery; the added files are in {}",
                                place_.string(), (work_ / "old").string()));
}

}  // namespace sleight::gallery
