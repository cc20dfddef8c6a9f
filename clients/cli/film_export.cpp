#include "clients/cli/film_export.h"

#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "clients/browse/archives/kept_animations.h"
#include "clients/cli/exported_animations.h"
#include "clients/pictures/animation_frames.h"
#include "common/archive/summary.h"

namespace sleight::cli {
namespace {

namespace fs = std::filesystem;

pictures::FrameViews views_called(const std::string& name) {
  if (name == "above") return pictures::FrameViews::above;
  return name == "front" ? pictures::FrameViews::front : pictures::FrameViews::both;
}

std::uint64_t bytes_at(const std::string& place) {
  std::error_code unknown;
  if (!fs::is_directory(place, unknown)) return fs::file_size(place, unknown);
  std::uint64_t bytes = 0;
  for (fs::directory_iterator it(place, unknown), end; !unknown && it != end; it.increment(unknown))
    bytes += it->file_size();
  return bytes;
}

}  // namespace

FilmExport::FilmExport(const archive::Source& source, FilmOptions options)
    : source_(source), options_(std::move(options)), scene_(browse::required_scene(source)) {}

WrittenFile FilmExport::write(const browse::AnimationId& id, const std::string& place,
                              const std::function<void(std::size_t, std::size_t)>& progress) const {
  gltf::Clip clip = clip_of(source_, scene_, id);
  const std::string title = fmt::format("{} {}", archive::summary_of(source_).world, id.text);
  const pictures::ShownAnimation shown{.title = title,
                                       .motion = std::move(clip.motion),
                                       .own = std::move(clip.own),
                                       .offsets_m = std::move(clip.offsets_m)};
  const pictures::FramesOptions frames{.fps = options_.fps,
                                       .look = {.views = views_called(options_.view)},
                                       .scale = options_.scale,
                                       .progress = progress};
  if (options_.format == "svg") {
    write_motion_svg(title, scene_, shown, place);
  } else if (options_.format == "png") {
    write_png_frames(scene_, shown, place, frames);
  } else {
    write_mp4(scene_, shown, place, frames);
  }
  return {.path = place, .ids = {id.text}, .bytes = bytes_at(place)};
}

}  // namespace sleight::cli
