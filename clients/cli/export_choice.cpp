#include "clients/cli/export_choice.h"

#include <fmt/format.h>

#include "clients/browse/archives/browsed.h"
#include "clients/browse/groups.h"
#include "clients/cli/groups_command.h"
#include "common/base/error.h"

namespace sleight::cli {
namespace {

[[noreturn]] void refuse(const archive::Source& source, const std::string& reason) {
  throw base::Error(base::ExitCode::usage, fmt::format("{}: {}", source.name(), reason));
}

std::vector<browse::AnimationId> selected(const archive::Source& source,
                                          const ExportChoice& choice) {
  browse::Browsed browsed;
  browsed.archives.push_back(
      {.path = source.name(), .index = index_of(source, source.name(), choice.file)});
  const std::vector<browse::Picked> meant = picked(browsed, {.select = choice.select});
  const auto id_of = [](const browse::Entry& entry) {
    return browse::AnimationId{
        .is_find = entry.name.is_find, .row = entry.row, .text = browse::short_text(entry.name)};
  };
  std::vector<browse::AnimationId> ids;
  if (choice.representatives && !meant.empty()) {
    const browse::Groups groups =
        groups_of(meant, *choice.representatives, browse::Grouping::medoids);
    for (const browse::AlikeGroup& group : groups.groups)
      ids.push_back(id_of(*meant[group.representative].entry));
  } else {
    for (const browse::Picked& one : meant)
      ids.push_back(id_of(*one.entry));
  }
  return ids;
}

}  // namespace

std::vector<browse::AnimationId> chosen(const archive::Source& source, const ExportChoice& choice,
                                        bool is_bounded) {
  if (!choice.ids.empty()) return browse::animations_of(source, choice.ids);
  const bool is_selected = !choice.select.empty() || choice.representatives;
  std::vector<browse::AnimationId> ids =
      is_selected ? selected(source, choice) : browse::animation_ids(source);
  if (ids.empty() && !choice.select.empty()) refuse(source, "no animation matches --select");
  if (ids.empty()) refuse(source, "the archive has no animations; run more scans");
  if (is_bounded && ids.size() > k_export_max && !choice.all && !choice.representatives) {
    refuse(source,
           fmt::format("{} {} animations, above the limit of {}; choose some with --ids, --select "
                       "or --representatives, or add --all",
                       is_selected ? "--select matches" : "the archive has", ids.size(),
                       k_export_max));
  }
  return ids;
}

}  // namespace sleight::cli
