#include "clients/pictures/strip_figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "clients/pictures/scene_painter.h"
#include "clients/plot/layout.h"

namespace sleight::pictures {
namespace {

constexpr double k_cell_height_px_max = 420;
constexpr double k_px_per_mm_max = 8;

struct StripSizes {
  std::size_t columns = k_strip_pictures;
  double px_per_mm = 0;
  double width_px = 0;
  double height_px = 0;
  double cell_width_px = 0;
  double cell_height_px = 0;  ///< with captions
};

StripSizes strip_sizes_in(const SceneExtent& extent, bool flat, std::size_t columns) {
  StripSizes sizes{.columns = columns};
  const auto count = static_cast<double>(columns);
  const auto rows = static_cast<double>(k_strip_pictures / columns);
  const double between_px = (count - 1) * k_between_px;
  const double room_px = (k_figure_width_px - 2 * plot::style::k_outer - between_px) / count;
  const double views_mm = (flat ? 0 : extent.depth_mm()) + extent.height_mm();
  const double others_px = k_caption_px + (flat ? 0 : k_between_px);
  sizes.px_per_mm = std::min({room_px / extent.width_mm(),
                              (k_cell_height_px_max - others_px) / views_mm, k_px_per_mm_max});
  sizes.cell_width_px = extent.width_mm() * sizes.px_per_mm;
  sizes.cell_height_px = views_mm * sizes.px_per_mm + others_px;
  sizes.width_px = count * sizes.cell_width_px + between_px;
  sizes.height_px = rows * sizes.cell_height_px + (rows - 1) * k_between_px;
  return sizes;
}

/// Chooses one or two rows, whichever shows the scene larger.
StripSizes strip_sizes(const SceneExtent& extent, bool flat) {
  const StripSizes one = strip_sizes_in(extent, flat, k_strip_pictures);
  const StripSizes two = strip_sizes_in(extent, flat, k_strip_pictures / 2);
  return two.px_per_mm > 1.2 * one.px_per_mm ? two : one;
}

double time_s(std::size_t picture, double end_s) {
  return end_s * static_cast<double>(picture) / (k_strip_pictures - 1);
}

/// Returns the extent of everything that is in the pictures. A body that is further away than the
/// extent of all paths is left out: it has left the scene.
SceneExtent strip_extent(const scene::Scene& scene, const ShownAnimation& animation, double end_s) {
  const SceneExtent paths = extent_of(scene, {animation});
  const math::Vec3 size_mm = paths.high_mm - paths.low_mm;
  SceneExtent extent = paths;
  for (const motion::Path& path : animation.motion.paths()) {
    for (std::size_t i = 0; i < k_strip_pictures && path.enters(); ++i) {
      const auto centre_m = path.centre_at(time_s(i, end_s));
      if (!centre_m) continue;
      const math::Vec3 place_mm = k_mm_per_m * *centre_m;
      const math::Vec3 off_mm = (place_mm - 0.5 * (paths.low_mm + paths.high_mm)).cwiseAbs();
      if ((off_mm.array() <= 1.5 * size_mm.maxCoeff()).all())
        extent.add(place_mm, reach_mm(scene, path.body()));
    }
  }
  return extent;
}

}  // namespace

plot::Figure strip_figure(const std::string& title, const scene::Scene& scene,
                          const ShownAnimation& animation, double end_s) {
  const SceneExtent extent = strip_extent(scene, animation, end_s);
  const bool flat = is_flat({animation});
  const StripSizes sizes = strip_sizes(extent, flat);
  plot::Figure figure{.title = title};
  figure.width_px = 2 * plot::style::k_outer + sizes.width_px;
  figure.height_px = 2 * plot::style::k_outer + plot::style::k_figure_title + 16 + sizes.height_px +
                     plot::style::k_panel_title + k_title_room_px;
  plot::Panel& panel =
      figure.panels.emplace_back(empty_panel(animation, sizes.width_px, sizes.height_px));
  ScenePainter painter(scene, extent, animation, panel);
  for (std::size_t i = 0; i < k_strip_pictures; ++i) {
    const double now_s = time_s(i, end_s);
    const double left_px =
        static_cast<double>(i % sizes.columns) * (sizes.cell_width_px + k_between_px);
    double top_px = sizes.height_px -
                    static_cast<double>(i / sizes.columns) * (sizes.cell_height_px + k_between_px);
    painter.caption({left_px, top_px - k_caption_size_px}, fmt::format("{:.2f} s", now_s));
    top_px -= k_caption_px;
    const auto draw = [&](Seen seen, double view_mm) {
      top_px -= view_mm * sizes.px_per_mm;
      const SceneView view = view_of(extent, seen, {left_px, top_px}, sizes.px_per_mm);
      painter.scenery(view);
      painter.instant(view, now_s, now_s);
      top_px -= k_between_px;
    };
    if (!flat) draw(Seen::from_above, extent.depth_mm());
    draw(Seen::from_front, extent.height_mm());
  }
  return figure;
}

}  // namespace sleight::pictures
