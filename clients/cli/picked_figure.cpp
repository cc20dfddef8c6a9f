#include "clients/cli/picked_figure.h"

#include "clients/cli/animation_figures.h"

#include <fmt/format.h>

#include <map>
#include <memory>
#include <utility>

#include "common/archive/format.h"
#include "common/archive/kept_motions.h"
#include "common/archive/remote/remote_source.h"
#include "common/archive/summary.h"
#include "common/base/error.h"

namespace sleight::cli {
namespace {

[[noreturn]] void refuse(const Picked& picked, const std::string& reason) {
  throw base::Error(base::ExitCode::bad_archive,
                    fmt::format("{}: its animation {} {}", picked.archive->path,
                                browse::short_text(picked.entry->name), reason));
}

/// The animation itself, out of its archive's file.
ShownAnimation read_picked(const archive::Source& source, const Picked& picked, std::string title) {
  const auto group = picked.entry->name.is_find ? archive::k_finds : archive::k_animations;
  const scene::Scene& scene = picked.archive->index.scene;
  if (archive::find_group(source, group) == nullptr) refuse(picked, "is there no more");
  const archive::KeptMotions motions(source, group);
  if (picked.entry->row >= motions.count()) refuse(picked, "is there no more");
  auto motion = motions.animation(picked.entry->row, scene);
  if (!motion) refuse(picked, motion.error());
  auto own = motions.variation(picked.entry->row, scene);
  if (!own) refuse(picked, own.error());
  return {.title = std::move(title),
          .motion = std::move(motion).value(),
          .own = std::move(own).value(),
          .offsets_m = motions.offsets_m(picked.entry->row, scene)};
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
      // Rows are those of the archive that was browsed.
      if (archive::summary_of(*source).content_digest != panel.picked.archive->index.digest)
        throw base::Error(fmt::format("{}: it was replaced meanwhile; ask again", path));
    }
    shown.push_back(read_picked(*source, panel.picked, panel.title));
  }
  return animation_figure(title, panels.front().picked.archive->index.scene, shown);
}

}  // namespace sleight::cli
