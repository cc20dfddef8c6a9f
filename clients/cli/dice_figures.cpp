#include "clients/cli/dice_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "clients/cli/kept_animations.h"
#include "clients/cli/request_numbers.h"
#include "clients/plot/layout.h"
#include "common/archive/summary.h"

namespace sleight::cli {
namespace {

using plot::Color;
using plot::Point;

constexpr double k_instant_s = 1.0 / 60;     ///< between the centres that are shown
constexpr std::size_t k_instants_max = 360;  ///< of a die; longer motions have rarer ones
constexpr std::size_t k_cube_every = 3;      ///< of these
constexpr double k_cube_faintest = 0.10;
constexpr double k_cube_strongest = 0.55;

constexpr double k_figure_width_px = 1280;
constexpr double k_panel_width_px_min = 560;
constexpr double k_above_height_px_max = 620;
constexpr double k_px_per_mm_max = 4.5;
constexpr double k_caption_px = 18;  ///< above a view
constexpr double k_caption_size_px = 11.5;
constexpr double k_between_px = 12;    ///< between the views
constexpr double k_grid_px_min = 5;    ///< closer lines are none
constexpr double k_title_room_px = 9;  ///< of a panel, beside the title's own height
constexpr double k_margin_mm = 4;

constexpr Color k_table{0xF6, 0xF4, 0xEF};
constexpr Color k_grid{0xE2, 0xDE, 0xD5};
constexpr Color k_ivory{0xFF, 0xFD, 0xF5};
constexpr Color k_shaded{0xE6, 0xE2, 0xD6};  ///< faces that look neither up nor to the front
constexpr Color k_ring{0xC4, 0x12, 0x30};    ///< no die has this colour

/// What is to be seen of all animations.
struct Extent {
  double left_mm = 1e300;
  double right_mm = -1e300;
  double near_mm = 1e300;
  double far_mm = -1e300;
  double bottom_mm = 0;
  double top_mm = 0;

  void add(const math::Vec3& place_mm, double around_mm) {
    add(projected(place_mm, Seen::from_above), around_mm);
    bottom_mm = std::min(bottom_mm, place_mm.z() - around_mm);
    top_mm = std::max(top_mm, place_mm.z() + around_mm);
  }
  void add(const Point& place_mm, double around_mm) {
    left_mm = std::min(left_mm, place_mm.x - around_mm);
    right_mm = std::max(right_mm, place_mm.x + around_mm);
    near_mm = std::min(near_mm, place_mm.y - around_mm);
    far_mm = std::max(far_mm, place_mm.y + around_mm);
  }
  double width_mm() const { return right_mm - left_mm; }
  double depth_mm() const { return far_mm - near_mm; }
  double height_mm() const { return top_mm - bottom_mm; }
};

/// Equally spaced from when a die is let go, then its rest.
std::vector<double> instants_of(const DieMotion& motion) {
  const double all_s = motion.rest_s() - motion.start_s();
  const auto most = static_cast<double>(k_instants_max);
  const double step_s = std::max(k_instant_s, all_s / most);
  const auto count = static_cast<std::size_t>(std::min(most, std::floor(all_s / step_s)));
  std::vector<double> instants;
  for (std::size_t i = 0; i <= count; ++i)
    instants.push_back(motion.start_s() + static_cast<double>(i) * step_s);
  instants.push_back(motion.rest_s());
  return instants;
}

Extent extent_of(const DiceScene& scene, const std::vector<DiceAnimation>& animations) {
  Extent extent;
  const double around_mm = 0.5 * std::sqrt(2.0) * scene.side_mm + k_margin_mm;
  for (const DiceAnimation& animation : animations) {
    for (const DieMotion& motion : animation.dice) {
      for (const double time_s : instants_of(motion)) {
        if (const auto pose = motion.pose_at(time_s)) extent.add(pose->centre_mm, around_mm);
      }
    }
  }
  for (const DiceScene::Place& place : scene.places)
    extent.add(place.centre_mm, place.tolerance_mm + k_margin_mm);
  for (const DiceScene::Region& region : scene.regions) {
    extent.add(region.low_mm, k_margin_mm);
    extent.add(region.high_mm, k_margin_mm);
  }
  return extent;
}

/// The sizes of a panel. Its own units are pixels from its lower left corner.
struct Arrangement {
  std::size_t columns = 1;
  double px_per_mm = 1;
  double width_px = 0;
  double above_height_px = 0;
  double front_height_px = 0;
  double height_px = 0;
};

Arrangement arrange(const Extent& extent, std::size_t panels) {
  Arrangement sizes;
  const bool is_wide = extent.width_mm() > 1.2 * extent.depth_mm();
  sizes.columns = std::min<std::size_t>(panels, is_wide ? 2 : 3);
  const auto columns = static_cast<double>(sizes.columns);
  const double room_px = (k_figure_width_px - 2 * plot::style::k_outer -
                          (columns - 1) * plot::style::k_between_panels) /
                         columns;
  sizes.px_per_mm =
      std::min({room_px / extent.width_mm(), k_above_height_px_max / extent.depth_mm(),
                k_above_height_px_max / extent.height_mm(), k_px_per_mm_max});
  sizes.width_px =
      std::max(extent.width_mm() * sizes.px_per_mm, std::min(room_px, k_panel_width_px_min));
  sizes.above_height_px = extent.depth_mm() * sizes.px_per_mm;
  sizes.front_height_px = extent.height_mm() * sizes.px_per_mm;
  // A word beneath the front, too.
  sizes.height_px = sizes.above_height_px + sizes.front_height_px + k_between_px + 3 * k_caption_px;
  return sizes;
}

/// Places a plane of the scene in a panel.
struct View {
  Seen seen;
  Point origin;  ///< where the scene's origin is drawn
  double px_per_mm;

  Point at(const Point& place_mm) const {
    return {origin.x + px_per_mm * place_mm.x, origin.y + px_per_mm * place_mm.y};
  }
};

/// Adds to one panel.
class Painter {
 public:
  Painter(const DiceScene& scene, const Extent& extent, plot::Panel& panel)
      : scene_(scene), extent_(extent), panel_(panel) {}

  void caption(const Point& at, std::string words) {
    panel_.series.push_back(
        plot::Text{.at = at, .text = std::move(words), .size_px = k_caption_size_px});
  }

  void from_above(const View& view, const std::vector<DieMotion>& dice) {
    const Point low = view.at({extent_.left_mm, extent_.near_mm});
    const Point high = view.at({extent_.right_mm, extent_.far_mm});
    panel_.series.push_back(plot::Rectangle{.low = low, .high = high, .color = k_table});
    grid(view);
    outline(low, high, k_grid);
    motions(view, dice);
    for (const DiceScene::Region& region : scene_.regions)
      outline(view.at(region.low_mm), view.at(region.high_mm), k_ring);
    for (const DiceScene::Place& place : scene_.places) {
      panel_.series.push_back(plot::Disc{.center = view.at(place.centre_mm),
                                         .radius_x = place.tolerance_mm * view.px_per_mm,
                                         .color = k_ring,
                                         .filled = false});
    }
  }

  void from_front(const View& view, const std::vector<DieMotion>& dice) {
    const Point ground = view.at({extent_.right_mm, 0});
    panel_.series.push_back(plot::Rectangle{
        .low = view.at({extent_.left_mm, extent_.bottom_mm}), .high = ground, .color = k_table});
    panel_.series.push_back(plot::Line{.points = {view.at({extent_.left_mm, 0}), ground},
                                       .color = plot::palette::k_grey,
                                       .width_px = 1});
    outline(view.at({extent_.left_mm, extent_.bottom_mm}),
            view.at({extent_.right_mm, extent_.top_mm}), k_grid);
    motions(view, dice);
  }

 private:
  void outline(const Point& low, const Point& high, const Color& color) {
    panel_.series.push_back(
        plot::Rectangle{.low = low, .high = high, .color = color, .filled = false});
  }
  void line(std::vector<Point> points, const Color& color, double width_px) {
    panel_.series.push_back(
        plot::Line{.points = std::move(points), .color = color, .width_px = width_px});
  }
  /// Through the control points.
  void grid(const View& view) {
    const double step_mm = scene_.spacing_mm;
    if (!(step_mm * view.px_per_mm >= k_grid_px_min)) return;
    const auto each = [&](double low_mm, double high_mm, const auto& draw) {
      for (double i = std::ceil(low_mm / step_mm); i * step_mm < high_mm; ++i)
        draw(i * step_mm);
    };
    each(extent_.left_mm, extent_.right_mm, [&](double x_mm) {
      line({view.at({x_mm, extent_.near_mm}), view.at({x_mm, extent_.far_mm})}, k_grid, 1);
    });
    each(extent_.near_mm, extent_.far_mm, [&](double y_mm) {
      line({view.at({extent_.left_mm, y_mm}), view.at({extent_.right_mm, y_mm})}, k_grid, 1);
    });
  }

  /// The ways of all dice, then the dice at rest, those further back first.
  void motions(const View& view, const std::vector<DieMotion>& dice) {
    for (const DieMotion& motion : dice)
      way(view, motion);
    std::vector<const DieMotion*> order;
    for (const DieMotion& motion : dice)
      order.push_back(&motion);
    const auto depth_mm = [&](const DieMotion* motion) {
      const math::Vec3 centre_mm = motion->last_pose().centre_mm;
      return view.seen == Seen::from_above ? centre_mm.z() : -centre_mm.y();
    };
    std::ranges::stable_sort(order, {}, depth_mm);
    for (const DieMotion* motion : order)
      lying(view, *motion);
  }

  void way(const View& view, const DieMotion& motion) {
    const Color color = plot::palette::series(motion.die());
    plot::Markers centres{.color = color, .radius_px = 1.3};
    plot::Line path{.color = color.with_opacity(0.6), .width_px = 0.8};
    const std::vector<double> instants = instants_of(motion);
    for (std::size_t i = 0; i + 1 < instants.size(); ++i) {
      const auto pose = motion.pose_at(instants[i]);
      if (!pose) continue;
      const Point centre = view.at(projected(pose->centre_mm, view.seen));
      centres.points.push_back(centre);
      path.points.push_back(centre);
      if (i % k_cube_every != 0) continue;
      const double share = static_cast<double>(i) / static_cast<double>(instants.size() - 1);
      cube(view, *pose,
           color.with_opacity(k_cube_faintest + share * (k_cube_strongest - k_cube_faintest)));
    }
    panel_.series.push_back(std::move(path));
    panel_.series.push_back(std::move(centres));
  }

  void cube(const View& view, const DiePose& pose, const Color& color) {
    for (const SeenFace& face : seen_faces(pose, scene_.side_mm, view.seen))
      line(closed(view, face), color, 1);
  }

  /// A die with its pips.
  void lying(const View& view, const DieMotion& motion) {
    const DiePose pose = motion.last_pose();
    for (const SeenFace& face : seen_faces(pose, scene_.side_mm, view.seen)) {
      const bool is_upper = face.face == upper_face(pose.orientation);
      std::vector<Point> corners = closed(view, face);
      const std::vector<Point> edges = corners;
      corners.pop_back();
      panel_.series.push_back(
          plot::Polygon{.corners = std::move(corners), .color = is_upper ? k_ivory : k_shaded});
      for (const auto& pip : face.pips_mm) {
        plot::Polygon round{.color = plot::palette::k_ink};
        for (const Point& corner : pip)
          round.corners.push_back(view.at(corner));
        panel_.series.push_back(std::move(round));
      }
      line(edges, plot::palette::series(motion.die()), 1.6);
    }
  }

  static std::vector<Point> closed(const View& view, const SeenFace& face) {
    std::vector<Point> points;
    for (const Point& corner : face.corners_mm)
      points.push_back(view.at(corner));
    points.push_back(points.front());
    return points;
  }

  const DiceScene& scene_;
  const Extent& extent_;
  plot::Panel& panel_;
};

/// What became of the dice.
std::string outcome_of(const DiceScene& scene, const std::vector<DieMotion>& dice) {
  std::string shown;
  double rest_s = dice.front().rest_s();
  double first_s = dice.front().start_s();
  double furthest_mm = 0;
  std::size_t places = 0;
  for (const DieMotion& motion : dice) {
    const DiePose pose = motion.last_pose();
    shown += fmt::format("{}{}", shown.empty() ? "" : ", ", upper_face(pose.orientation));
    rest_s = std::max(rest_s, motion.rest_s());
    first_s = std::min(first_s, motion.start_s());
    for (const DiceScene::Place& place : scene.places) {
      if (place.die != motion.die()) continue;
      ++places;
      furthest_mm = std::max(furthest_mm, std::hypot(pose.centre_mm.x() - place.centre_mm.x,
                                                     pose.centre_mm.y() - place.centre_mm.y));
    }
  }
  const std::string off = places == 0   ? ""
                          : places == 1 ? fmt::format("{:.1f} mm from the place, ", furthest_mm)
                                        : fmt::format("at most {:.1f} mm off, ", furthest_mm);
  return fmt::format("up: {}; {}at rest after {:.2f} s", shown, off, rest_s - first_s);
}

plot::Panel animation_panel(const DiceScene& scene, const Extent& extent, const Arrangement& sizes,
                            const DiceAnimation& animation) {
  plot::Panel panel{.title = animation.title,
                    .x_range = plot::Range{0, sizes.width_px},
                    .y_range = plot::Range{0, sizes.height_px},
                    .equal_aspect = true,
                    .axes = false,
                    .legend = false};
  Painter painter(scene, extent, panel);
  const double scale = sizes.px_per_mm;
  const double above_low_px = sizes.height_px - k_caption_px - sizes.above_height_px;
  const double front_low_px = k_caption_px;
  painter.caption({0, sizes.height_px - k_caption_size_px},
                  "from above; ring: wanted place of the centre");
  painter.from_above({.seen = Seen::from_above,
                      .origin = {-scale * extent.left_mm, above_low_px - scale * extent.near_mm},
                      .px_per_mm = scale},
                     animation.dice);
  painter.caption({0, front_low_px + sizes.front_height_px + k_caption_px - k_caption_size_px},
                  "from the front");
  painter.from_front({.seen = Seen::from_front,
                      .origin = {-scale * extent.left_mm, front_low_px - scale * extent.bottom_mm},
                      .px_per_mm = scale},
                     animation.dice);
  painter.caption({0, k_caption_px - k_caption_size_px - 2}, outcome_of(scene, animation.dice));
  return panel;
}

/// The table from above alone, in millimetres.
plot::Panel above_panel(const DiceScene& scene, const Extent& extent,
                        const DiceAnimation& animation) {
  plot::Panel panel{
      .title = fmt::format("{}; {}", animation.title, outcome_of(scene, animation.dice)),
      .x_label = "x (mm)",
      .y_label = "y (mm)",
      .equal_aspect = true,
      .grid = false,
      .legend = false};
  Painter(scene, extent, panel)
      .from_above({.seen = Seen::from_above, .origin = {0, 0}, .px_per_mm = 1}, animation.dice);
  return panel;
}

}  // namespace

plot::Figure dice_figure(const std::string& title, const DiceScene& scene,
                         const std::vector<DiceAnimation>& animations) {
  const Extent extent = extent_of(scene, animations);
  const Arrangement sizes = arrange(extent, animations.size());
  const auto columns = static_cast<double>(sizes.columns);
  const double rows = std::ceil(static_cast<double>(animations.size()) / columns);
  plot::Figure figure{
      .title = title,
      .width_px = 2 * plot::style::k_outer + columns * sizes.width_px +
                  (columns - 1) * plot::style::k_between_panels,
      .height_px = 2 * plot::style::k_outer + plot::style::k_figure_title + 16 +
                   rows * (sizes.height_px + plot::style::k_panel_title + k_title_room_px) +
                   (rows - 1) * plot::style::k_between_panels,
      .columns = sizes.columns,
      .panels = {}};
  for (const DiceAnimation& animation : animations)
    figure.panels.push_back(animation_panel(scene, extent, sizes, animation));
  return figure;
}

plot::Figure dice_animations(const archive::Source& source, const DiceScene& scene,
                             const DiceAnimationOptions& options) {
  const std::vector<std::size_t> chosen = choose_animations(source, options.chain, options.count);
  const std::string step =
      scan_label(RequestNumbers(archive::summary_of(source).request_text, source.name()));
  std::vector<DiceAnimation> animations;
  for (const std::size_t i : chosen) {
    const auto step_of = [&](double draw) { return fmt::format("{} {}", step, draw); };
    animations.push_back({.title = where_found(source, i, step_of),
                          .dice = read_dice_motions(source, i, scene.dice)});
  }
  const std::string title = fmt::format("Dice on a random table: {} animation{}", chosen.size(),
                                        chosen.size() == 1 ? "" : "s");
  if (options.front) return dice_figure(title, scene, animations);
  plot::Figure figure{.title = title, .panels = {}};
  const Extent extent = extent_of(scene, animations);
  for (const DiceAnimation& animation : animations)
    figure.panels.push_back(above_panel(scene, extent, animation));
  return figure;
}

}  // namespace sleight::cli
