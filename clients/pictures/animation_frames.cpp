#include "clients/pictures/animation_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include <sys/stat.h>
#include <unistd.h>

#include "clients/pictures/ffmpeg.h"
#include "clients/pictures/scene_painter.h"
#include "clients/plot/film.h"
#include "clients/plot/layout.h"
#include "clients/plot/save.h"
#include "common/base/check.h"
#include "common/base/error.h"
#include "common/base/file_system.h"
#include "common/base/output_beside.h"

namespace sleight::pictures {
namespace {

namespace fs = std::filesystem;

constexpr double k_title_px = plot::style::k_panel_title + 9;  ///< height of a title
constexpr double k_width_px_min = 320;                         ///< for the captions
constexpr double k_frame_px_per_mm_max = 8;
constexpr double k_side_px_min = 100;

double up_to_even(double side) {
  return 2 * std::ceil(0.5 * side);
}

struct FrameSizes {
  std::vector<Seen> views{};
  bool beside = false;  ///< beside each other instead of below
  double px_per_mm = 0;
  double width_px = 0;  ///< panel width
  double height_px = 0;
};

double view_height_mm(const SceneExtent& extent, Seen seen) {
  return seen == Seen::from_above ? extent.depth_mm() : extent.height_mm();
}

FrameSizes sizes_in(const SceneExtent& extent, const std::vector<Seen>& views, bool beside,
                    double room_width_px, double room_height_px) {
  const auto columns = static_cast<double>(beside ? views.size() : 1);
  const auto rows = static_cast<double>(beside ? 1 : views.size());
  double high_mm = 0;
  for (const Seen seen : views) {
    const double one_mm = view_height_mm(extent, seen);
    high_mm = beside ? std::max(high_mm, one_mm) : high_mm + one_mm;
  }
  const double between_x_px = (columns - 1) * k_between_px;
  const double captions_px = rows * k_caption_px + (rows - 1) * k_between_px;
  FrameSizes sizes{.views = views, .beside = beside};
  sizes.px_per_mm = std::min({(room_width_px - between_x_px) / (columns * extent.width_mm()),
                              (room_height_px - captions_px) / high_mm, k_frame_px_per_mm_max});
  sizes.width_px = columns * extent.width_mm() * sizes.px_per_mm + between_x_px;
  sizes.height_px = high_mm * sizes.px_per_mm + captions_px;
  return sizes;
}

/// Arranges the views below or beside each other, whichever shows them larger.
FrameSizes sizes_of(const SceneExtent& extent, bool flat, const FrameLook& look) {
  std::vector<Seen> views;
  if (look.views == FrameViews::above || (look.views == FrameViews::both && !flat))
    views.push_back(Seen::from_above);
  if (look.views != FrameViews::above) views.push_back(Seen::from_front);
  const double width_px = look.width_max_px - 2 * plot::style::k_outer;
  const double height_px = look.height_max_px - 2 * plot::style::k_outer - k_title_px;
  const FrameSizes beneath = sizes_in(extent, views, false, width_px, height_px);
  const FrameSizes beside = sizes_in(extent, views, true, width_px, height_px);
  return beside.px_per_mm > beneath.px_per_mm ? beside : beneath;
}

/// Draws the frames of an animation. Holds the parts that frames share, and borrows all arguments.
class FrameArtist {
 public:
  FrameArtist(const scene::Scene& scene, const ShownAnimation& animation, const FrameLook& look)
      : scene_(scene), animation_(animation), extent_(extent_of(scene, {animation})) {
    CHECK_GE(std::min(look.width_max_px, look.height_max_px), k_side_px_min);
    const FrameSizes sizes = sizes_of(extent_, is_flat({animation}), look);
    const double around_px = 2 * plot::style::k_outer;
    const double width_px =
        std::max(sizes.width_px, std::min(k_width_px_min, look.width_max_px - around_px));
    figure_.width_px = up_to_even(around_px + width_px);
    figure_.height_px = up_to_even(around_px + k_title_px + sizes.height_px);
    panel_ = empty_panel(animation, figure_.width_px - around_px,
                         figure_.height_px - around_px - k_title_px);
    plot::Point corner{0, panel_.y_range->high};
    for (const Seen seen : sizes.views) {
      const double height_px = sizes.px_per_mm * view_height_mm(extent_, seen);
      views_.push_back(
          view_of(extent_, seen, {corner.x, corner.y - k_caption_px - height_px}, sizes.px_per_mm));
      if (sizes.beside) {
        corner.x += sizes.px_per_mm * extent_.width_mm() + k_between_px;
      } else {
        corner.y -= k_caption_px + height_px + k_between_px;
      }
    }
  }
  FrameArtist(const FrameArtist&) = delete;
  FrameArtist& operator=(const FrameArtist&) = delete;

  /// Returns the parts that don't move, which are the same in all frames.
  plot::Figure still() const { return figure_of(still_panel()); }
  /// Returns the moving parts of a frame.
  plot::Figure moving(double t_s) const {
    plot::Panel panel = panel_;
    add_moving(t_s, panel);
    return figure_of(std::move(panel));
  }
  plot::Figure whole(double t_s) const {
    plot::Panel panel = still_panel();
    add_moving(t_s, panel);
    return figure_of(std::move(panel));
  }

 private:
  plot::Figure figure_of(plot::Panel panel) const {
    plot::Figure figure = figure_;
    figure.panels.push_back(std::move(panel));
    return figure;
  }

  plot::Panel still_panel() const {
    plot::Panel panel = panel_;
    ScenePainter painter(scene_, extent_, animation_, panel);
    for (const SceneView& view : views_) {
      painter.scenery(view);
      const bool from_above = view.seen == Seen::from_above;
      const plot::Point left = view.at(projected(extent_.low_mm, view.seen));
      const plot::Point top = view.at(projected(extent_.high_mm, view.seen));
      painter.caption({left.x, top.y + k_caption_px - k_caption_size_px},
                      from_above ? "from above" : "from the front");
    }
    return panel;
  }

  void add_moving(double t_s, plot::Panel& panel) const {
    ScenePainter painter(scene_, extent_, animation_, panel);
    painter.caption({panel.x_range->high, panel.y_range->high - k_caption_size_px},
                    fmt::format("{:.2f} s", t_s), plot::Anchor::end);
    for (const SceneView& view : views_)
      painter.instant(view, t_s, t_s);
  }

  const scene::Scene& scene_;
  const ShownAnimation& animation_;
  SceneExtent extent_;
  plot::Figure figure_;  ///< sizes only
  plot::Panel panel_;    ///< without series
  std::vector<SceneView> views_;
};

/// Draws all frames in order. Calls `take` with each frame's number, from 0, after the frame is
/// shown.
void draw_frames(const FrameArtist& artist, plot::Film& film, std::size_t count,
                 const FramesOptions& options, const std::function<void(std::size_t frame)>& take) {
  for (std::size_t frame = 0; frame < count; ++frame) {
    film.show(artist.moving(static_cast<double>(frame) / options.fps));
    take(frame);
    if (options.progress) options.progress(frame + 1, count);
  }
}

/// A folder that is filled under a temporary name and renamed when complete.
class FolderBeside {
 public:
  explicit FolderBeside(const std::string& folder)
      : place_(base::where_links_lead(fs::path(folder).lexically_normal().string())) {
    std::error_code none;
    if (fs::exists(place_, none) && !(fs::is_directory(place_, none) && fs::is_empty(place_, none)))
      refuse_used();
    const std::string beside = fmt::format("{}.tmp.{}", place_, ::getpid());
    if (::mkdir(beside.c_str(), 0777) != 0)
      throw base::Error(
          fmt::format("{}: can't create the folder: {}", beside, std::strerror(errno)));
    beside_ = beside;
  }
  FolderBeside(const FolderBeside&) = delete;
  FolderBeside& operator=(const FolderBeside&) = delete;
  /// Removes the folder unless it was renamed.
  ~FolderBeside() {
    std::error_code none;
    if (!beside_.empty()) fs::remove_all(beside_, none);
  }

  const std::string& path() const { return beside_; }

  void put_in_place() {
    // rename() refuses to replace a folder that isn't empty.
    if (::rename(beside_.c_str(), place_.c_str()) != 0) {
      if (errno == ENOTEMPTY || errno == EEXIST || errno == ENOTDIR) refuse_used();
      throw base::Error(
          fmt::format("{}: can't create the folder: {}", place_, std::strerror(errno)));
    }
    beside_.clear();
  }

 private:
  [[noreturn]] void refuse_used() const {
    throw base::Error(base::ExitCode::usage,
                      fmt::format("{}: already exists; name a new or empty folder", place_));
  }

  std::string place_;
  std::string beside_;  ///< empty: not created, or already renamed
};

}  // namespace

plot::Figure frame_figure(const scene::Scene& scene, const ShownAnimation& animation, double t_s,
                          const FrameLook& look) {
  return FrameArtist(scene, animation, look).whole(t_s);
}

std::size_t frame_count(const motion::Animation& motion, double fps) {
  if (!(fps > 0 && fps <= k_fps_max)) {
    throw base::Error(
        base::ExitCode::usage,
        fmt::format("{} frames per second: expected more than 0 and at most {}", fps, k_fps_max));
  }
  const double count = std::floor(std::max(0.0, motion.end_s()) * fps) + 1;
  if (count > static_cast<double>(k_frames_max)) {
    throw base::Error(
        base::ExitCode::usage,
        fmt::format("an animation of {:.6g} s at {} frames per second has more frames than the "
                    "maximum of {}; use fewer frames per second",
                    motion.end_s(), fps, k_frames_max));
  }
  return static_cast<std::size_t>(count);
}

std::size_t write_png_frames(const scene::Scene& scene, const ShownAnimation& animation,
                             const std::string& folder, const FramesOptions& options) {
  const std::size_t count = frame_count(animation.motion, options.fps);
  FolderBeside beside(folder);
  const FrameArtist artist(scene, animation, options.look);
  plot::Film film(artist.still(), options.scale);
  base::PosixFileSystem files;
  draw_frames(artist, film, count, options, [&](std::size_t frame) {
    const base::Bytes png = film.png();
    base::write_text_file(files,
                          fmt::format("{}/{}-{:04}.png", beside.path(), options.name, frame + 1),
                          {reinterpret_cast<const char*>(png.data()), png.size()});
  });
  beside.put_in_place();
  return count;
}

std::size_t write_mp4(const scene::Scene& scene, const ShownAnimation& animation,
                      const std::string& path, const FramesOptions& options) {
  const std::size_t count = frame_count(animation.motion, options.fps);
  const FrameArtist artist(scene, animation, options.look);
  plot::Film film(artist.still(), options.scale);
  base::OutputBeside beside(path);
  Ffmpeg ffmpeg({.output = beside.path(),
                 .columns = film.columns(),
                 .rows = film.rows(),
                 .fps = options.fps});
  draw_frames(artist, film, count, options, [&](std::size_t) { ffmpeg.send(film.pixels()); });
  ffmpeg.finish();
  beside.put_in_place();
  return count;
}

void write_motion_svg(const std::string& title, const scene::Scene& scene,
                      const ShownAnimation& animation, const std::string& path) {
  if (!path.ends_with(".svg")) {
    throw base::Error(base::ExitCode::usage,
                      fmt::format("{}: expected a file name that ends in .svg", path));
  }
  plot::save(animation_figure(title, scene, {animation}), path);
}

}  // namespace sleight::pictures
