#include "clients/cli/export_choice.h"

#include <algorithm>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "clients/browse/groups.h"
#include "clients/cli/browsed.h"
#include "common/base/error.h"

namespace sleight::cli {
namespace {

[[noreturn]] void refuse(const archive::Source& source, const std::string& reason) {
  throw base::Error(base::ExitCode::usage, fmt::format("{}: {}", source.name(), reason));
}

std::vector<AnimationId> selected(const archive::Source& source, const ExportChoice& choice) {
  Browsed browsed;
  browsed.archives.push_back({.path = source.name(), .index = index_of(source, source.name())});
  const std::vector<Picked> meant = picked(browsed, {.select = choice.select});
  const auto id_of = [](const browse::Entry& entry) {
    return AnimationId{
        .is_find = entry.name.is_find, .row = entry.row, .text = browse::short_text(entry.name)};
  };
  std::vector<AnimationId> ids;
  if (choice.representatives && !meant.empty()) {
    std::vector<const browse::Entry*> entries;
    for (const Picked& one : meant)
      entries.push_back(one.entry);
    if (entries.size() > browse::k_full_matrix_max &&
        *choice.representatives > browse::k_full_matrix_max) {
      refuse(source, fmt::format("--representatives: at most {}", browse::k_full_matrix_max));
    }
    const auto groups =
        browse::groups_of(entries, browsed.archives.front().index.scene,
                          {.groups = *choice.representatives,
                           .threads = std::max(1U, std::thread::hardware_concurrency())});
    for (const browse::AlikeGroup& group : groups.groups)
      ids.push_back(id_of(*entries[group.representative]));
  } else {
    for (const Picked& one : meant)
      ids.push_back(id_of(*one.entry));
  }
  return ids;
}

}  // namespace

std::vector<AnimationId> chosen(const archive::Source& source, const ExportChoice& choice,
                                bool is_bounded) {
  if (!choice.ids.empty()) return animations_of(source, choice.ids);
  const bool is_selected = !choice.select.empty() || choice.representatives;
  std::vector<AnimationId> ids = is_selected ? selected(source, choice) : animation_ids(source);
  if (ids.empty() && is_selected) refuse(source, "no animation is meant by --select");
  if (ids.empty()) {
    throw base::Error(fmt::format("{}: it holds no animation; run more scans", source.name()));
  }
  if (is_bounded && ids.size() > k_export_max && !choice.all && !choice.representatives) {
    refuse(source, fmt::format("{} {} animations, more than {}; name some with --ids, --select or "
                               "--representatives, or give --all",
                               is_selected ? "these are" : "it holds", ids.size(), k_export_max));
  }
  return ids;
}

}  // namespace sleight::cli
