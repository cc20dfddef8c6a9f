#include "clients/pictures/picked_figure.h"

#include "clients/pictures/animation_figures.h"

#include <fmt/format.h>

#include <map>
#include <memory>
#include <utility>

#include "clients/browse/archives/kept_animations.h"
#include "common/archive/format.h"
#include "common/archive/kept_motions.h"
#include "common/archive/remote/remote_source.h"
#include "common/archive/summary.h"
#include "common/base/error.h"

namespace sleight::pictures {
namespace {

ShownAnimation read_picked(const archive::Source& source, const browse::Picked& picked,
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

}  // namespace

plot::Figure picked_figure(const std::string& title, const std::vector<PickedPanel>& panels) {
  std::map<std::string, std::unique_ptr<archive::Source>> sources;
  std::vector<ShownAnimation> shown;
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
  return animation_figure(title, panels.front().picked.archive->index.scene, shown);
}

}  // namespace sleight::pictures
