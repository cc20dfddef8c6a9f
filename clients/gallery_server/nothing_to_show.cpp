#include "clients/gallery_server/nothing_to_show.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sleight::gallery {

std::string nothing_to_show(const json::Value& state, const std::vector<std::string>& paths) {
  const auto& archives = state["archives"];
  const auto is_of = [](const char* word) {
    return [word](const auto& archive) { return archive["state"] == word; };
  };
  if (archives.empty()) {
    const auto& left_out = state["left_out"];
    const std::string besides =
        left_out.empty()
            ? std::string()
            : fmt::format(" (skipped: {}: {})", left_out[0]["name"].template get<std::string>(),
                          left_out[0]["reason"].template get<std::string>());
    return terminal::shown_on_one_line(
        fmt::format("{}: no archive (*.h5) to show{}; name an archive or its folder (subfolders "
                    "are not searched), or wait until an archive appears",
                    fmt::join(paths, ", "), besides));
  }
  // The page shows what was read of a damaged archive, and a job's archive may still appear.
  if (!std::ranges::all_of(archives.elements(), is_of("damaged"))) return {};
  if (std::ranges::any_of(archives.elements(),
                          [](const auto& one) { return one["generation"] != 0; }))
    return {};
  const auto& first = archives[0];
  const std::string more =
      archives.size() == 1 ? std::string() : fmt::format(" (and {} more)", archives.size() - 1);
  return terminal::shown_on_one_line(fmt::format(
      "nothing to show: {}: {}{}; name an archive that "
      "`sleight direct` wrote, or wait until the file is replaced",
      first["name"].template get<std::string>(), first["words"].template get<std::string>(), more));
}

}  // namespace sleight::gallery
