#include "clients/pictures/animation_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "clients/analysis/request_numbers.h"
#include "clients/browse/archives/kept_animations.h"
#include "clients/pictures/scene_painter.h"
#include "clients/plot/layout.h"
#include "clients/plot/text.h"
#include "clients/shapes/facets.h"
#include "common/archive/format.h"
#include "common/archive/kept_motions.h"
#include "common/archive/summary.h"

namespace sleight::pictures {
namespace {

constexpr double k_panel_width_px_min = 560;
constexpr double k_above_height_px_max = 620;
constexpr double k_figure_px_per_mm_max = 4.5;
constexpr double k_beside_px = 24;  ///< between the view from above and the instants
constexpr std::size_t k_instants = 8;
constexpr double k_panel_height_max_px = 400;
constexpr double k_above_share_max = 0.6;  ///< maximum share of the width, for the view from above

/// Explains the symbols in the view from above.
std::string caption_from_above(const scene::Scene& scene, const ShownAnimation& animation,
                               std::string words) {
  bool has_tint = false;
  bool has_ring = false;
  for (const scene::Part& part : scene.parts) {
    const scene::Feature& feature = scene.features[part.feature];
    if (feature.kind != scene::FeatureKind::wanted) continue;
    const bool is_ring = feature.body != scene::k_none || part.shape == scene::Shape::disc;
    (is_ring ? has_ring : has_tint) = true;
  }
  if (has_tint) words += "; tinted: places to fill";
  if (has_ring) words += "; ring: wanted place of the centre";
  if (!animation.own.points.empty()) words += "; darker: lower";
  return words;
}

double end_s(const ShownAnimation& animation) {
  return animation.motion.end_s();
}

double first_s(const ShownAnimation& animation) {
  double first = 1e300;
  for (const motion::Path& path : animation.motion.paths()) {
    if (path.enters()) first = std::min(first, path.start_s());
  }
  return first < 1e300 ? first : 0;
}

/// Returns the outcome: the dice's upper faces, and distances from the goals.
std::string outcome_of(const scene::Scene& scene, const ShownAnimation& animation) {
  std::string up;
  double furthest_mm = 0;
  std::size_t places = 0;
  for (const motion::Path& path : animation.motion.paths()) {
    if (!path.enters()) continue;
    const motion::Pose pose = *path.pose_at(path.rest_s());
    for (const scene::Part& part : parts_of(scene.parts, path.body())) {
      if (part.shape == scene::Shape::die)
        up += fmt::format("{}{}", up.empty() ? "" : ", ",
                          shapes::upper_face(math::composed(pose.orientation, part.orientation)));
    }
    for (const scene::Part& part : scene.parts) {
      const scene::Feature& feature = scene.features[part.feature];
      if (part.shape != scene::Shape::disc || feature.kind != scene::FeatureKind::wanted ||
          feature.body != static_cast<std::int32_t>(path.body()))
        continue;
      ++places;
      const math::Vec3 off_m = pose.centre_m - part.position_m;
      furthest_mm = std::max(furthest_mm, k_mm_per_m * std::hypot(off_m.x(), off_m.y()));
    }
  }
  std::string words = up.empty() ? "" : fmt::format("up: {}; ", up);
  if (places == 1) words += fmt::format("{:.1f} mm from the place, ", furthest_mm);
  if (places > 1) words += fmt::format("at most {:.1f} mm off, ", furthest_mm);
  return words + fmt::format("at rest after {:.2f} s", end_s(animation) - first_s(animation));
}

// Figures of few bodies: their paths from above and, below that view, from the front.

struct WaysSizes {
  std::size_t columns = 1;
  double px_per_mm = 1;
  double width_px = 0;
  double above_height_px = 0;
  double front_height_px = 0;
  double height_px = 0;
};

WaysSizes ways_sizes(const SceneExtent& extent, std::size_t panels, bool flat) {
  WaysSizes sizes;
  const bool is_wide = extent.width_mm() > 1.2 * extent.depth_mm();
  sizes.columns = std::min<std::size_t>(panels, is_wide ? 2 : 3);
  const auto columns = static_cast<double>(sizes.columns);
  const double room_px = (k_figure_width_px - 2 * plot::style::k_outer -
                          (columns - 1) * plot::style::k_between_panels) /
                         columns;
  const double depth_mm = flat ? 0 : extent.depth_mm();
  sizes.px_per_mm = std::min(room_px / extent.width_mm(), k_figure_px_per_mm_max);
  if (depth_mm > 0) sizes.px_per_mm = std::min(sizes.px_per_mm, k_above_height_px_max / depth_mm);
  sizes.px_per_mm = std::min(sizes.px_per_mm, k_above_height_px_max / extent.height_mm());
  sizes.width_px =
      std::max(extent.width_mm() * sizes.px_per_mm, std::min(room_px, k_panel_width_px_min));
  sizes.above_height_px = depth_mm * sizes.px_per_mm;
  sizes.front_height_px = extent.height_mm() * sizes.px_per_mm;
  // Reserve space for a caption below the front view too.
  sizes.height_px = sizes.front_height_px + 2 * k_caption_px;
  if (!flat) sizes.height_px += sizes.above_height_px + k_between_px + k_caption_px;
  return sizes;
}

plot::Panel ways_panel(const scene::Scene& scene, const SceneExtent& extent, const WaysSizes& sizes,
                       bool flat, const ShownAnimation& animation) {
  plot::Panel panel = empty_panel(animation, sizes.width_px, sizes.height_px);
  ScenePainter painter(scene, extent, animation, panel);
  const double scale = sizes.px_per_mm;
  if (!flat) {
    const double low_px = sizes.height_px - k_caption_px - sizes.above_height_px;
    painter.caption({0, sizes.height_px - k_caption_size_px},
                    caption_from_above(scene, animation, "from above"));
    const SceneView above = view_of(extent, Seen::from_above, {0, low_px}, scale);
    painter.scenery(above);
    painter.ways(above);
  }
  painter.caption({0, 2 * k_caption_px + sizes.front_height_px - k_caption_size_px},
                  "from the front");
  const SceneView front = view_of(extent, Seen::from_front, {0, k_caption_px}, scale);
  painter.scenery(front);
  painter.ways(front);
  painter.caption({0, k_caption_px - k_caption_size_px - 2}, outcome_of(scene, animation));
  return panel;
}

// Figures of many bodies: a view from above at rest, and views of several instants from the front.

struct InstantSizes {
  std::size_t frame_columns = k_instants;
  double frame_px_per_mm = 0.01;
  double above_px_per_mm = 0.01;
  double width_px = 0;
  double height_px = 0;
};

/// Returns sizes for frames in this many columns, as large as width and height allow. The view from
/// above is as high as all frames together, but limited by its share of the width.
InstantSizes instant_sizes_in(const SceneExtent& extent, std::size_t columns) {
  const double rows = static_cast<double>(k_instants) / static_cast<double>(columns);
  const double captions_px = rows * k_caption_px + (rows - 1) * k_between_px;
  const double frames_x_mm = static_cast<double>(columns) * extent.width_mm();
  const double frames_z_mm = rows * extent.height_mm();
  const double all_px = k_figure_width_px - 2 * plot::style::k_outer;
  const double room_px = all_px - k_beside_px - static_cast<double>(columns - 1) * k_between_px;
  // Solve for equal heights: ratio * (frames_z * scale + others_px) + frames_x * scale = room.
  const double ratio = extent.width_mm() / extent.depth_mm();
  const double others_px = captions_px - 2 * k_caption_px;
  const double equal = (room_px - ratio * others_px) / (ratio * frames_z_mm + frames_x_mm);
  const double least = (room_px - k_above_share_max * all_px) / frames_x_mm;
  const double by_height = (k_panel_height_max_px - captions_px) / frames_z_mm;
  InstantSizes sizes{.frame_columns = columns,
                     .frame_px_per_mm = std::min(std::max(equal, least), by_height),
                     .width_px = all_px};
  sizes.height_px = frames_z_mm * sizes.frame_px_per_mm + captions_px;
  sizes.above_px_per_mm = std::min((sizes.height_px - 2 * k_caption_px) / extent.depth_mm(),
                                   k_above_share_max * all_px / extent.width_mm());
  return sizes;
}

/// Chooses the number of columns for which both kinds of views are large.
InstantSizes instant_sizes(const SceneExtent& extent) {
  InstantSizes best{.height_px = k_panel_height_max_px};
  for (const std::size_t columns : {8U, 4U, 2U, 1U}) {
    const InstantSizes next = instant_sizes_in(extent, columns);
    if (next.frame_px_per_mm <= 0 || next.above_px_per_mm <= 0) continue;
    if (next.frame_px_per_mm * next.above_px_per_mm > best.frame_px_per_mm * best.above_px_per_mm)
      best = next;
  }
  return best;
}

/// Returns equally spaced times, and the time at which all bodies rest. The equally spaced times
/// begin when the first body enters, and end when the last body to enter has bounced.
std::array<double, k_instants> instants_of(const ShownAnimation& animation) {
  constexpr double k_bounces_s = 0.4;  // a fall of a few centimetres takes an eighth of a second
  const double begin_s = first_s(animation);
  double last_s = begin_s;
  for (const motion::Path& path : animation.motion.paths()) {
    if (path.enters()) last_s = std::max(last_s, path.start_s());
  }
  const double rest_s = end_s(animation);
  const double pour_s = std::min(last_s + k_bounces_s, rest_s) - begin_s;
  std::array<double, k_instants> instants{};
  for (std::size_t i = 0; i < k_instants; ++i)
    instants[i] = begin_s + pour_s * static_cast<double>(i) / (k_instants - 2);
  instants.back() = rest_s;
  return instants;
}

/// Returns a caption that fits above a frame.
std::string frame_caption(std::size_t instant, double time_s, double width_px) {
  const std::string time = fmt::format("{:.2f} s", time_s);
  const std::string whole = instant == 0                ? "from the front, " + time
                            : instant + 1 == k_instants ? time + ", at rest"
                                                        : time;
  return plot::text_width_px(whole, k_caption_size_px) <= width_px ? whole : time;
}

plot::Panel instants_panel(const scene::Scene& scene, const SceneExtent& extent,
                           const InstantSizes& sizes, const ShownAnimation& animation) {
  plot::Panel panel = empty_panel(animation, sizes.width_px, sizes.height_px);
  ScenePainter painter(scene, extent, animation, panel);
  const auto instants = instants_of(animation);
  const double above_px = extent.depth_mm() * sizes.above_px_per_mm;
  const double above_low_px = sizes.height_px - k_caption_px - above_px;
  const double above_width_px = extent.width_mm() * sizes.above_px_per_mm;
  painter.caption({0, sizes.height_px - k_caption_size_px},
                  caption_from_above(scene, animation, "from above, at rest"));
  painter.caption({0.5 * above_width_px, above_low_px - k_caption_size_px}, "front",
                  plot::Anchor::middle);
  const SceneView above =
      view_of(extent, Seen::from_above, {0, above_low_px}, sizes.above_px_per_mm);
  painter.scenery(above);
  painter.instant(above, instants.back(), instants.back());

  const double frame_width_px = extent.width_mm() * sizes.frame_px_per_mm;
  const double frame_height_px = extent.height_mm() * sizes.frame_px_per_mm;
  for (std::size_t i = 0; i < k_instants; ++i) {
    const auto column = static_cast<double>(i % sizes.frame_columns);
    const auto row = static_cast<double>(i / sizes.frame_columns);
    const double left_px = above_width_px + k_beside_px + column * (frame_width_px + k_between_px);
    const double top_px = sizes.height_px - row * (k_caption_px + frame_height_px + k_between_px);
    painter.caption({left_px, top_px - k_caption_size_px},
                    frame_caption(i, instants[i], frame_width_px));
    const SceneView front =
        view_of(extent, Seen::from_front, {left_px, top_px - k_caption_px - frame_height_px},
                sizes.frame_px_per_mm);
    painter.scenery(front);
    painter.instant(front, instants[i == 0 ? 0 : i - 1], instants[i]);
  }
  return panel;
}

/// A single view in millimetres.
plot::Panel single_panel(const scene::Scene& scene, const SceneExtent& extent, bool flat,
                         const ShownAnimation& animation) {
  const bool is_many = scene.bodies() > k_ways_max;
  plot::Panel panel{
      .title = is_many ? animation.title
                       : fmt::format("{}; {}", animation.title, outcome_of(scene, animation)),
      .x_label = "x (mm)",
      .y_label = flat ? "z (mm)" : "y (mm)",
      .equal_aspect = true,
      .grid = false,
      .legend = false};
  ScenePainter painter(scene, extent, animation, panel);
  const SceneView view{.seen = flat ? Seen::from_front : Seen::from_above, .origin = {0, 0}};
  painter.scenery(view);
  if (is_many) {
    painter.instant(view, end_s(animation), end_s(animation));
  } else {
    painter.ways(view);
  }
  return panel;
}

}  // namespace

plot::Figure animation_figure(const std::string& title, const scene::Scene& scene,
                              const std::vector<ShownAnimation>& animations, bool whole) {
  const SceneExtent extent = extent_of(scene, animations);
  const bool flat = is_flat(animations);
  plot::Figure figure{.title = title, .panels = {}};
  if (!whole) {
    for (const ShownAnimation& animation : animations)
      figure.panels.push_back(single_panel(scene, extent, flat, animation));
    return figure;
  }
  const double head_px = 2 * plot::style::k_outer + plot::style::k_figure_title + 16;
  if (scene.bodies() > k_ways_max) {
    const InstantSizes sizes = instant_sizes(extent);
    figure.width_px = k_figure_width_px;
    figure.height_px = head_px;
    for (const ShownAnimation& animation : animations) {
      figure.panels.push_back(instants_panel(scene, extent, sizes, animation));
      figure.height_px += sizes.height_px + plot::style::k_panel_title + k_title_room_px;
    }
    figure.height_px += plot::style::k_between_panels * static_cast<double>(animations.size() - 1);
    return figure;
  }
  const WaysSizes sizes = ways_sizes(extent, animations.size(), flat);
  const auto columns = static_cast<double>(sizes.columns);
  const double rows = std::ceil(static_cast<double>(animations.size()) / columns);
  figure.width_px = 2 * plot::style::k_outer + columns * sizes.width_px +
                    (columns - 1) * plot::style::k_between_panels;
  figure.height_px = head_px +
                     rows * (sizes.height_px + plot::style::k_panel_title + k_title_room_px) +
                     (rows - 1) * plot::style::k_between_panels;
  figure.columns = sizes.columns;
  for (const ShownAnimation& animation : animations)
    figure.panels.push_back(ways_panel(scene, extent, sizes, flat, animation));
  return figure;
}

plot::Figure animation_figure(const archive::Source& source,
                              const AnimationFigureOptions& options) {
  const scene::Scene scene = browse::required_scene(source);
  const std::vector<std::size_t> chosen =
      browse::choose_animations(source, options.chain, options.count);
  const archive::Summary summary = archive::summary_of(source);
  const analysis::RequestNumbers numbers(summary.request_text, source.name());
  const std::string step = numbers.find("sampler", "iterations_per_scan") ? "iteration" : "scan";
  const double per_scan = numbers.find("sampler", "iterations_per_scan").value_or(1);
  const archive::KeptMotions motions(source, browse::drawn_group(source));
  std::vector<ShownAnimation> animations;
  for (const std::size_t i : chosen) {
    browse::KeptAnimation kept =
        browse::kept_animation(source, motions, i, scene, fmt::format("{}", i));
    if (kept.motion.segment_count() == 0) browse::refuse_animation(source, i, "has no motion");
    animations.push_back(
        {.title = browse::where_found(
             source, i, [&](double draw) { return fmt::format("{} {}", step, per_scan * draw); }),
         .motion = std::move(kept.motion),
         .own = std::move(kept.own),
         .offsets_m = std::move(kept.offsets_m)});
  }
  return animation_figure(fmt::format("{}: {} animation{}", summary.world, chosen.size(),
                                      chosen.size() == 1 ? "" : "s"),
                          scene, animations, options.whole);
}

}  // namespace sleight::pictures
