#include "clients/gallery_server/page_folder.h"

#include <filesystem>
#include <system_error>

#include <fmt/format.h>

#include "common/base/error.h"

namespace sleight::gallery {

namespace {

std::string folder_of_page(const char* name) {
  namespace fs = std::filesystem;
  std::error_code failure;
  const fs::path program = fs::read_symlink("/proc/self/exe", failure);
  if (failure) {
    throw base::Error(
        fmt::format("/proc/self/exe: cannot find this program's folder: {}", failure.message()));
  }
  const fs::path folder = program.parent_path().parent_path() / "share" / "sleight" / name;
  if (!fs::exists(folder / "index.html", failure)) {
    throw base::Error(fmt::format(
        "{}: the gallery's page is missing. Building the page requires npm packages: run "
        "deploy/install-deps and build again (cmake without -DSLEIGHT_GALLERY=OFF)",
        folder.string()));
  }
  return folder.string();
}

}  // namespace

std::string page_folder() {
  return folder_of_page("gallery");
}

std::string saved_page_folder() {
  return folder_of_page("gallery-saved");
}

}  // namespace sleight::gallery
