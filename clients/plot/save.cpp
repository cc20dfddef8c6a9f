#include "clients/plot/save.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <span>

#include "clients/plot/png.h"
#include "clients/plot/svg.h"
#include "common/base/error.h"

namespace sleight::plot {

namespace {

void write_whole(const std::string& path, std::span<const std::byte> bytes) {
  const std::string part = path + ".part";
  std::ofstream file(part, std::ios::binary | std::ios::trunc);
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  file.close();
  std::error_code failure;
  if (!file) {
    failure = std::error_code(errno, std::generic_category());
  } else {
    std::filesystem::rename(part, path, failure);
  }
  if (!failure) return;
  std::error_code ignored;
  std::filesystem::remove(part, ignored);
  throw base::Error(
      fmt::format("{}: the picture can't be written: {}; does the folder exist and "
                  "has the disk room?",
                  path, failure.message()));
}

}  // namespace

void save(const Figure& figure, const std::string& path, const SaveOptions& options) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::ranges::transform(ending, ending.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (ending == ".svg") {
    const std::string svg = to_svg(figure, options.notes);
    write_whole(path, std::as_bytes(std::span(svg)));
  } else if (ending == ".png") {
    if (!options.notes.empty()) {
      throw base::Error(base::ExitCode::usage,
                        fmt::format("{}: only an SVG has room for notes", path));
    }
    write_whole(path, to_png(figure));
  } else {
    throw base::Error(base::ExitCode::usage,
                      fmt::format("{}: expected a picture's name ending in .svg or .png", path));
  }
}

}  // namespace sleight::plot
