#include "clients/gallery_server/nothing_to_show.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "clients/service_client/service_call.h"
#include "common/json/value.h"

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
            : fmt::format(" (left out: {}: {})", left_out[0]["name"].template get<std::string>(),
                          left_out[0]["reason"].template get<std::string>());
    return terminal::shown_on_one_line(fmt::format(
        "{}: there is no archive (*.h5) to show{}; folders below are not searched: name "
        "an archive or its own folder, or wait until one comes",
        fmt::join(paths, ", "), besides));
  }
  // What was read of a damaged one is shown, and a job's that isn't there yet may come.
  if (!std::ranges::all_of(archives.elements(), is_of("damaged"))) return {};
  if (std::ranges::any_of(archives.elements(),
                          [](const auto& one) { return one["generation"] != 0; }))
    return {};
  const auto& first = archives[0];
  const std::string more =
      archives.size() == 1 ? std::string() : fmt::format(" (and {} more)", archives.size() - 1);
  return terminal::shown_on_one_line(fmt::format(
      "there is nothing to show: {}: {}{}; name an archive that "
      "`sleight direct` made, or wait until it is replaced",
      first["name"].template get<std::string>(), first["words"].template get<std::string>(), more));
}

}  // namespace sleight::gallery
