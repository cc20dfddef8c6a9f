#include "clients/cli/groups_command.h"

#include <fmt/format.h>

#include <cstddef>
#include <map>
#include <memory>
#include <utility>

#include "clients/browse/archives/kept_animations.h"
#include "clients/cli/browsed_json.h"
#include "clients/pictures/animation_figures.h"
#include "clients/pictures/scene_view.h"
#include "clients/plot/figure.h"
#include "clients/plot/save.h"
#include "clients/report/text_table.h"
#include "clients/terminal/output.h"
#include "clients/terminal/terminal.h"
#include "common/archive/format.h"
#include "common/archive/kept_motions.h"
#include "common/archive/remote/remote_source.h"
#include "common/archive/summary.h"
#include "common/base/cores.h"
#include "common/base/error.h"
#include "common/json/value.h"

namespace sleight::cli {
namespace {

constexpr std::size_t k_picked_panels_max = 24;

struct PickedPanel {
  browse::Picked picked{};
  std::string title{};
};

pictures::ShownAnimation read_picked(const archive::Source& source, const browse::Picked& picked,
                                     std::string title) {
  const auto group = picked.entry->name.is_find ? archive::k_finds : archive::k_animations;
  const scene::Scene& scene = picked.archive->index.scene;
  const std::string name = browse::short_text(picked.entry->name);
  if (archive::find_group(source, group) == nullptr)
    browse::refuse_animation(source, name, "no longer exists");
  const archive::KeptMotions motions(source, group);
  if (picked.entry->row >= motions.count())
    browse::refuse_animation(source, name, "no longer exists");
  browse::KeptAnimation kept =
      browse::kept_animation(source, motions, picked.entry->row, scene, name);
  return {.title = std::move(title),
          .motion = std::move(kept.motion),
          .own = std::move(kept.own),
          .offsets_m = std::move(kept.offsets_m)};
}

/// Draws a panel per animation, read from its archive's file. Throws base::Error(bad_archive) if
/// the file doesn't contain the animation any more. REQUIRES: at least one panel, comparable
/// scenes.
plot::Figure picked_figure(const std::string& title, const std::vector<PickedPanel>& panels) {
  std::map<std::string, std::unique_ptr<archive::Source>> sources;
  std::vector<pictures::ShownAnimation> shown;
  for (const PickedPanel& panel : panels) {
    const std::string& path = panel.picked.archive->path;
    std::unique_ptr<archive::Source>& source = sources[path];
    if (source == nullptr) {
      source = archive::remote::open_remote(path);
      // Row numbers refer to the archive as it was browsed.
      if (archive::summary_of(*source).content_digest != panel.picked.archive->index.digest)
        throw base::Error(
            fmt::format("{}: the archive changed after it was browsed; try again", path));
    }
    shown.push_back(read_picked(*source, panel.picked, panel.title));
  }
  return pictures::animation_figure(title, panels.front().picked.archive->index.scene, shown);
}

void print_groups(const browse::Browsed& browsed, const std::vector<browse::Picked>& picked,
                  const browse::Groups& groups) {
  report::TextTable table{.columns = {{.head = "group", .to_the_right = true},
                                      {.head = "animations", .to_the_right = true},
                                      {.head = "representative"},
                                      {.head = "mean mm", .to_the_right = true},
                                      {.head = "max mm", .to_the_right = true},
                                      {.head = "log_prior", .to_the_right = true, .rank = 1},
                                      {.head = "rest_s", .to_the_right = true, .rank = 2}}};
  const bool has_archives = browsed.archives.size() > 1;
  if (has_archives) table.columns.push_back({.head = "archive", .rank = 3});
  for (std::size_t i = 0; i < groups.groups.size(); ++i) {
    const browse::AlikeGroup& group = groups.groups[i];
    const browse::Picked& representative = picked[group.representative];
    std::vector<std::string> row{
        fmt::format("{}", i + 1),
        fmt::format("{}", group.members.size()),
        name_among(browsed, representative.entry->name),
        fmt::format("{:.1f}", pictures::k_mm_per_m * group.mean_m),
        fmt::format("{:.1f}", pictures::k_mm_per_m * group.greatest_m),
        browse::shown_number(representative.entry->numbers[browse::k_log_prior]),
        fmt::format("{:.3f}", representative.entry->end_s)};
    if (has_archives) row.push_back(representative.archive->path);
    table.rows.push_back(std::move(row));
  }
  fmt::print("{}", to_text(table, terminal::width_of(stdout)));
  fmt::print(
      "{} animation{} in {} group{}; the columns in mm are differences from the representative\n",
      picked.size(), picked.size() == 1 ? "" : "s", groups.groups.size(),
      groups.groups.size() == 1 ? "" : "s");
  if (groups.is_approximate) {
    fmt::print(
        "The groups come from a sample; each remaining animation joined the nearest group.\n");
  }
}

json::Value groups_json(const browse::Browsed& browsed, const std::vector<browse::Picked>& picked,
                        const browse::Groups& groups) {
  json::Value json = archives_json(browsed);
  json["animations"] = picked.size();
  json["approximate"] = groups.is_approximate;
  json["groups"] = json::Value::array();
  for (const browse::AlikeGroup& group : groups.groups) {
    json::Value members = json::Value::array();
    for (const std::size_t member : group.members)
      members.push_back(name_among(browsed, picked[member].entry->name));
    json["groups"].push_back(
        {{"representative", animation_json(browsed, picked[group.representative])},
         {"mean_m", group.mean_m},
         {"greatest_m", group.greatest_m},
         {"members", std::move(members)}});
  }
  return json;
}

}  // namespace

browse::Groups groups_of(const std::vector<browse::Picked>& picked, std::uint64_t groups,
                         browse::Grouping by) {
  std::vector<const browse::Entry*> entries;
  for (const browse::Picked& one : picked) {
    const browse::BrowsedArchive& first = *picked.front().archive;
    if (!browse::are_comparable(first.index.scene, one.archive->index.scene)) {
      throw base::Error(base::ExitCode::usage,
                        fmt::format("{} and {} have different bodies, so their animations can't be "
                                    "compared; group each archive separately",
                                    first.path, one.archive->path));
    }
    entries.push_back(one.entry);
  }
  if (entries.size() > browse::k_full_matrix_max && groups > browse::k_full_matrix_max) {
    throw base::Error(
        base::ExitCode::usage,
        fmt::format(
            "expected at most {} groups, because groups of {} animations come from a sample",
            browse::k_full_matrix_max, entries.size()));
  }
  if (entries.empty()) return {};
  return browse::groups_of(entries, picked.front().archive->index.scene,
                           {.groups = groups, .by = by, .threads = base::cores_here()});
}

int group_animations(const GroupsOptions& options) {
  if (!options.output.empty() && !options.output.ends_with(".svg") &&
      !options.output.ends_with(".png"))
    throw base::Error(
        base::ExitCode::usage,
        fmt::format("{}: expected a file name that ends in .svg or .png", options.output));
  for (const std::string& path : options.paths) {
    if (!options.output.empty()) terminal::refuse_same_file(path, options.output);
  }
  return terminal::with_results([&] {
    browse::Browsed browsed = browse::browse_archives(options.paths);
    const std::vector<browse::Picked> all = picked(browsed, options.asked);
    say_what_is_missing(browsed);
    const browse::Groups groups = groups_of(
        all, options.groups,
        options.by == "hierarchy" ? browse::Grouping::hierarchy : browse::Grouping::medoids);
    if (options.json) {
      fmt::print("{}\n", groups_json(browsed, all, groups).dump(2));
    } else if (all.empty()) {
      fmt::print("0 of {} animations match\n", browsed.animations());
    } else {
      print_groups(browsed, all, groups);
    }
    if (!options.output.empty() && !all.empty()) {
      std::vector<PickedPanel> panels;
      for (const browse::AlikeGroup& group : groups.groups) {
        if (panels.size() == k_picked_panels_max) break;
        panels.push_back(
            {.picked = all[group.representative],
             .title = fmt::format("{} of {} are like {}", group.members.size(), all.size(),
                                  name_among(browsed, all[group.representative].entry->name))});
      }
      plot::save(picked_figure(fmt::format("{} groups", groups.groups.size()), panels),
                 options.output);
      if (!options.json) fmt::print("{}\n", options.output);
    }
    return static_cast<int>(base::ExitCode::ok);
  });
}

}  // namespace sleight::cli
