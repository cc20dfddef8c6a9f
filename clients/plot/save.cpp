#include "clients/plot/save.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <ostream>
#include <span>

#include "clients/plot/png.h"
#include "clients/plot/svg.h"
#include "common/base/error.h"
#include "common/base/output_beside.h"

namespace sleight::plot {

namespace {

void write_whole(const std::string& path, std::span<const std::byte> bytes) {
  base::write_output(path, [&](std::ostream& file) {
    file.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  });
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
                        fmt::format("{}: only SVG files can contain notes", path));
    }
    write_whole(path, to_png(figure));
  } else {
    throw base::Error(base::ExitCode::usage,
                      fmt::format("{}: expected a file name that ends in .svg or .png", path));
  }
}

}  // namespace sleight::plot
