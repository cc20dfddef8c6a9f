#include "clients/pictures/scene_painter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "clients/plot/scene_colors.h"
#include "clients/shapes/facets.h"
#include "common/scene/surface.h"

namespace sleight::pictures {
namespace {

using math::Vec3;
using plot::Color;
using plot::Point;
using plot::scene_colors::k_ivory;
using plot::scene_colors::k_ring;
using plot::scene_colors::k_table;
using plot::scene_colors::k_tint;

constexpr double k_instant_s = 1.0 / 60;     ///< interval between the centres that are shown
constexpr std::size_t k_instants_max = 360;  ///< per body; longer motions have longer intervals
constexpr std::size_t k_outline_every = 3;   ///< in centres
constexpr double k_faintest = 0.10;
constexpr double k_strongest = 0.55;
constexpr std::size_t k_points_per_way = 60;
constexpr double k_number_px_min = 7;  ///< smaller numbers are illegible
constexpr double k_grid_px_min = 5;    ///< a denser grid isn't drawn
constexpr double k_margin_mm = 4;
constexpr double k_flat_m = 1e-6;  ///< bodies that move less in y move in a plane

constexpr Color k_grid{0xE2, 0xDE, 0xD5};
constexpr Color k_low{0xFA, 0xFA, 0xFA};  ///< the lowest pieces of fixed things
constexpr Color k_high = plot::scene_colors::k_fixed;
constexpr double k_see_through = 0.15;       ///< opacity of fixed things, from the front
constexpr Color k_shaded{0xE6, 0xE2, 0xD6};  ///< faces that point neither up nor to the front
constexpr Color k_white{0xFF, 0xFF, 0xFF};

Color between(const Color& a, const Color& b, double share) {
  const auto channel = [share](std::uint8_t x, std::uint8_t y) {
    return static_cast<std::uint8_t>(std::lround((1 - share) * x + share * y));
  };
  return {channel(a.red, b.red), channel(a.green, b.green), channel(a.blue, b.blue)};
}

/// Returns white for dark colours and ink for light colours.
Color on_top_of(const Color& color) {
  return 0.3 * color.red + 0.59 * color.green + 0.11 * color.blue < 140 ? k_white
                                                                        : plot::palette::k_ink;
}

std::vector<Point> closed(std::vector<Point> points) {
  if (!points.empty()) points.push_back(points.front());
  return points;
}

}  // namespace

void SceneExtent::add(const Vec3& place_mm, double around_mm) {
  low_mm = low_mm.cwiseMin(Vec3(place_mm - Vec3::Constant(around_mm)));
  high_mm = high_mm.cwiseMax(Vec3(place_mm + Vec3::Constant(around_mm)));
}

std::vector<double> instants_of(const motion::Path& path) {
  const double all_s = path.rest_s() - path.start_s();
  const auto most = static_cast<double>(k_instants_max);
  const double step_s = std::max(k_instant_s, all_s / most);
  const auto count = static_cast<std::size_t>(std::min(most, std::floor(all_s / step_s)));
  std::vector<double> instants;
  for (std::size_t i = 0; i <= count; ++i)
    instants.push_back(path.start_s() + static_cast<double>(i) * step_s);
  instants.push_back(path.rest_s());
  return instants;
}

SceneExtent extent_of(const scene::Scene& scene, const std::vector<ShownAnimation>& animations) {
  SceneExtent extent;
  for (const ShownAnimation& animation : animations) {
    for (const motion::Path& path : animation.motion.paths()) {
      if (!path.enters()) continue;
      const double around_mm = reach_mm(scene, path.body()) + k_margin_mm;
      for (const double time_s : instants_of(path)) {
        if (const auto centre_m = path.centre_at(time_s))
          extent.add(k_mm_per_m * *centre_m, around_mm);
      }
    }
    for (const scene::Part& part : animation.own.parts)
      extent.add(k_mm_per_m * part.position_m, 0.5 * k_mm_per_m * part.size_m.maxCoeff());
  }
  for (const scene::Part& part : scene.parts) {
    if (scene.features[part.feature].kind == scene::FeatureKind::body) continue;
    if (part.shape == scene::Shape::mesh) {
      for (std::uint32_t i = 0; i < part.triangles; ++i) {
        for (const std::uint32_t vertex : scene.triangles[part.first_triangle + i]) {
          // Include fixed things such as walls only up to a margin around the bodies' range.
          const Vec3 place_m =
              part.position_m + math::rotated(part.orientation, scene.vertices[vertex].place_m);
          extent.add(k_mm_per_m * place_m.cwiseMax(scene.low_m).cwiseMin(scene.high_m),
                     k_margin_mm);
        }
      }
    } else if (part.shape != scene::Shape::ground && part.shape != scene::Shape::surface) {
      Vec3 half_mm = Vec3::Zero();  // of a box about the turned part
      for (int axis = 0; axis < 3; ++axis)
        half_mm +=
            math::rotated(part.orientation, 0.5 * k_mm_per_m * part.size_m[axis] * Vec3::Unit(axis))
                .cwiseAbs();
      const Vec3 middle_mm = k_mm_per_m * part.position_m;
      extent.add(Vec3(middle_mm - half_mm), k_margin_mm);
      extent.add(Vec3(middle_mm + half_mm), k_margin_mm);
    }
  }
  return extent;
}

bool is_flat(const std::vector<ShownAnimation>& animations) {
  double low_m = 1e300;
  double high_m = -1e300;
  for (const ShownAnimation& animation : animations) {
    for (const motion::Path& path : animation.motion.paths()) {
      for (const motion::Segment& segment : path.segments()) {
        low_m = std::min(low_m, segment.position_m.y());
        high_m = std::max(high_m, segment.position_m.y());
      }
    }
  }
  return high_m - low_m <= k_flat_m;
}

SceneView view_of(const SceneExtent& extent, Seen seen, const Point& low_px, double px_per_mm) {
  const Point low = projected(extent.low_mm, seen);
  return {.seen = seen,
          .origin = {low_px.x - px_per_mm * low.x, low_px.y - px_per_mm * low.y},
          .px_per_mm = px_per_mm};
}

plot::Panel empty_panel(const ShownAnimation& animation, double width_px, double height_px) {
  return {.title = animation.title,
          .x_range = plot::Range{0, width_px},
          .y_range = plot::Range{0, height_px},
          .equal_aspect = true,
          .axes = false,
          .legend = false};
}

ScenePainter::ScenePainter(const scene::Scene& scene, const SceneExtent& extent,
                           const ShownAnimation& animation, plot::Panel& panel)
    : scene_(scene), extent_(extent), animation_(animation), panel_(panel) {}

void ScenePainter::caption(const Point& at, std::string words, plot::Anchor anchor) {
  panel_.series.push_back(plot::Text{
      .at = at, .text = std::move(words), .anchor = anchor, .size_px = k_caption_size_px});
}

void ScenePainter::outline(const Point& low, const Point& high, const Color& color,
                           double width_px) {
  panel_.series.push_back(plot::Rectangle{
      .low = low, .high = high, .color = color, .filled = false, .width_px = width_px});
}

void ScenePainter::line(std::vector<Point> points, const Color& color, double width_px) {
  panel_.series.push_back(
      plot::Line{.points = std::move(points), .color = color, .width_px = width_px});
}

void ScenePainter::polygon(const SceneView& view, const std::vector<Point>& corners_mm,
                           const Color& color) {
  plot::Polygon shape{.color = color};
  for (const Point& corner : corners_mm)
    shape.corners.push_back(view.at(corner));
  panel_.series.push_back(std::move(shape));
}

/// Clips a convex outline to the extent, one side after the other.
std::vector<Point> ScenePainter::clipped(const SceneView& view,
                                         std::vector<Point> corners_mm) const {
  const bool from_above = view.seen == Seen::from_above;
  const std::array<double, 4> bounds{
      extent_.low_mm.x(), from_above ? extent_.low_mm.y() : extent_.low_mm.z(),
      -extent_.high_mm.x(), from_above ? -extent_.high_mm.y() : -extent_.high_mm.z()};
  for (std::size_t side = 0; side < bounds.size(); ++side) {
    const auto inside_by = [&](const Point& p) {
      const double along = side % 2 == 0 ? p.x : p.y;
      return (side < 2 ? along : -along) - bounds[side];
    };
    std::vector<Point> kept;
    for (std::size_t i = 0; i < corners_mm.size(); ++i) {
      const Point& a = corners_mm[i];
      const Point& b = corners_mm[(i + 1) % corners_mm.size()];
      const double of_a = inside_by(a);
      const double of_b = inside_by(b);
      if (of_a >= 0) kept.push_back(a);
      if ((of_a < 0) == (of_b < 0)) continue;
      const double share = of_a / (of_a - of_b);
      kept.push_back({a.x + share * (b.x - a.x), a.y + share * (b.y - a.y)});
    }
    corners_mm = std::move(kept);
  }
  return corners_mm;
}

bool ScenePainter::is_in(const SceneView& view, const Point& place_mm) const {
  const bool from_above = view.seen == Seen::from_above;
  const double low = from_above ? extent_.low_mm.y() : extent_.low_mm.z();
  const double high = from_above ? extent_.high_mm.y() : extent_.high_mm.z();
  return place_mm.x >= extent_.low_mm.x() && place_mm.x <= extent_.high_mm.x() &&
         place_mm.y >= low && place_mm.y <= high;
}

Color ScenePainter::color_of(std::uint32_t body) const {
  return plot::scene_colors::of_body(body, scene_.bodies());
}

void ScenePainter::scenery(const SceneView& view) {
  const Point low = view.at(projected(extent_.low_mm, view.seen));
  const Point high = view.at(projected(extent_.high_mm, view.seen));
  if (view.seen == Seen::from_above)
    panel_.series.push_back(plot::Rectangle{.low = low, .high = high, .color = k_table});
  const auto each = [&](std::span<const scene::Part> parts, scene::FeatureKind kind,
                        const auto& draw) {
    for (const scene::Part& part : parts) {
      if (scene_.features[part.feature].kind == kind) draw(part);
    }
  };
  each(scene_.parts, scene::FeatureKind::fixed, [&](const scene::Part& part) {
    if (part.shape == scene::Shape::surface) surface(view, part);
    if (part.shape == scene::Shape::ground) ground(view, part);
  });
  each(scene_.parts, scene::FeatureKind::fixed,
       [&](const scene::Part& part) { fixed(view, part); });
  each(animation_.own.parts, scene::FeatureKind::fixed,
       [&](const scene::Part& part) { fixed(view, part); });
  each(scene_.parts, scene::FeatureKind::wanted,
       [&](const scene::Part& part) { wanted(view, part); });
  outline(low, high, k_grid);
}

/// Draws the patches (darker if lower), or only a grid if the control points are unknown.
void ScenePainter::surface(const SceneView& view, const scene::Part& part) {
  if (view.seen == Seen::from_front) {
    table_below(view, k_mm_per_m * part.position_m.z());
    return;
  }
  const double step_mm = k_mm_per_m * part.size_m.z();
  if (!(step_mm * view.px_per_mm >= k_grid_px_min)) return;
  if (!animation_.own.points.empty()) {
    const scene::Surface known(animation_.own.points, part.size_m.z());
    double low_m = 1e300;
    double high_m = -1e300;
    const auto height_m = [&](const scene::Surface::Patch& patch) {
      return *known.height_m((patch.i + 0.5) * known.spacing_m(),
                             (patch.j + 0.5) * known.spacing_m());
    };
    for (const scene::Surface::Patch& patch : known.patches()) {
      low_m = std::min(low_m, height_m(patch));
      high_m = std::max(high_m, height_m(patch));
    }
    for (const scene::Surface::Patch& patch : known.patches()) {
      const double share = high_m > low_m ? (height_m(patch) - low_m) / (high_m - low_m) : 1;
      const Point low_mm{std::max(patch.i * step_mm, extent_.low_mm.x()),
                         std::max(patch.j * step_mm, extent_.low_mm.y())};
      const Point high_mm{std::min((patch.i + 1) * step_mm, extent_.high_mm.x()),
                          std::min((patch.j + 1) * step_mm, extent_.high_mm.y())};
      if (low_mm.x >= high_mm.x || low_mm.y >= high_mm.y) continue;
      panel_.series.push_back(plot::Rectangle{.low = view.at(low_mm),
                                              .high = view.at(high_mm),
                                              .color = between(k_grid, k_white, share)});
    }
  }
  for (double i = std::ceil(extent_.low_mm.x() / step_mm); i * step_mm < extent_.high_mm.x(); ++i)
    line({view.at({i * step_mm, extent_.low_mm.y()}), view.at({i * step_mm, extent_.high_mm.y()})},
         k_grid, 1);
  for (double j = std::ceil(extent_.low_mm.y() / step_mm); j * step_mm < extent_.high_mm.y(); ++j)
    line({view.at({extent_.low_mm.x(), j * step_mm}), view.at({extent_.high_mm.x(), j * step_mm})},
         k_grid, 1);
}

void ScenePainter::ground(const SceneView& view, const scene::Part& part) {
  const double z_mm = k_mm_per_m * part.position_m.z();
  if (view.seen == Seen::from_front && z_mm >= extent_.low_mm.z()) table_below(view, z_mm);
}

/// Draws a table whose top has this height, from the front.
void ScenePainter::table_below(const SceneView& view, double z_mm) {
  const Point right = view.at({extent_.high_mm.x(), z_mm});
  panel_.series.push_back(plot::Rectangle{
      .low = view.at({extent_.low_mm.x(), extent_.low_mm.z()}), .high = right, .color = k_table});
  line({view.at({extent_.low_mm.x(), z_mm}), right}, plot::palette::k_grey, 1);
}

/// Draws fixed things. Seen from above, higher pieces are darker; seen from the front, all are
/// transparent.
void ScenePainter::fixed(const SceneView& view, const scene::Part& part) {
  const std::vector<FlatPiece> pieces =
      flat_pieces(scene_, part, {}, view.seen, animation_.offsets_m);
  double low_mm = 1e300;
  double high_mm = -1e300;
  for (const FlatPiece& piece : pieces) {
    low_mm = std::min(low_mm, piece.height_mm);
    high_mm = std::max(high_mm, piece.height_mm);
  }
  const bool from_above = view.seen == Seen::from_above;
  for (const FlatPiece& piece : pieces) {
    const double share = high_mm > low_mm ? (piece.height_mm - low_mm) / (high_mm - low_mm) : 1;
    FlatPiece shown = piece;
    if (piece.radius_mm == 0) shown.corners_mm = clipped(view, piece.corners_mm);
    if (piece.radius_mm == 0 && shown.corners_mm.empty()) continue;
    fill(view, shown,
         from_above ? between(k_low, k_high, share) : k_high.with_opacity(k_see_through));
    // Triangles get no edge, because they are parts of a larger surface.
    if (piece.corners_mm.size() != 3) edge(view, shown, plot::palette::k_grey, 0.8);
  }
}

/// Draws goals: a tinted area for any body, a ring for a single body.
void ScenePainter::wanted(const SceneView& view, const scene::Part& part) {
  const bool is_of_one = scene_.features[part.feature].body != scene::k_none;
  if (view.seen == Seen::from_front) {
    // Draw a line on the ground.
    const double half_mm = 0.5 * k_mm_per_m * part.size_m.x();
    const Point middle_mm = projected_mm(part.position_m, view.seen);
    line({view.at({middle_mm.x - half_mm, middle_mm.y}),
          view.at({middle_mm.x + half_mm, middle_mm.y})},
         is_of_one ? k_ring : k_tint, 2.5);
    return;
  }
  if (part.shape == scene::Shape::disc) {
    panel_.series.push_back(
        plot::Disc{.center = view.at(projected_mm(part.position_m, view.seen)),
                   .radius_x = 0.5 * k_mm_per_m * part.size_m.x() * view.px_per_mm,
                   .color = k_ring,
                   .filled = false});
    return;
  }
  for (const FlatPiece& piece : flat_pieces(scene_, part, {}, view.seen, {})) {
    if (is_of_one) {
      edge(view, piece, k_ring, 1.4);
    } else {
      fill(view, piece, k_tint);
    }
  }
}

void ScenePainter::ways(const SceneView& view) {
  Bodies at_rest;
  for (const motion::Path& path : animation_.motion.paths()) {
    if (!path.enters()) continue;
    way(view, path);
    if (const auto pose = path.pose_at(path.rest_s())) at_rest.emplace_back(*pose, path.body());
  }
  bodies(view, std::move(at_rest));
}

void ScenePainter::bodies(const SceneView& view, Bodies seen) {
  std::ranges::stable_sort(
      seen, {}, [&](const auto& one) { return depth_mm(one.first.centre_m, view.seen); });
  for (const auto& [pose, number] : seen)
    body(view, number, pose);
}

void ScenePainter::way(const SceneView& view, const motion::Path& path) {
  const Color color = color_of(path.body());
  plot::Markers centres{.color = color, .radius_px = 1.3};
  plot::Line track{.color = color.with_opacity(0.6), .width_px = 0.8};
  const std::vector<double> instants = instants_of(path);
  for (std::size_t i = 0; i + 1 < instants.size(); ++i) {
    const auto pose = path.pose_at(instants[i]);
    if (!pose) continue;
    const Point centre = view.at(projected_mm(pose->centre_m, view.seen));
    centres.points.push_back(centre);
    track.points.push_back(centre);
    if (i % k_outline_every != 0) continue;
    const double share = static_cast<double>(i) / static_cast<double>(instants.size() - 1);
    outlines(view, path.body(), *pose,
             color.with_opacity(k_faintest + share * (k_strongest - k_faintest)));
  }
  panel_.series.push_back(std::move(track));
  panel_.series.push_back(std::move(centres));
}

void ScenePainter::outlines(const SceneView& view, std::uint32_t number, const motion::Pose& pose,
                            const Color& color) {
  for (const scene::Part& part : parts_of(scene_.parts, number)) {
    for (const FlatPiece& piece : flat_pieces(scene_, part, pose, view.seen, {}))
      edge(view, piece, color, 1);
  }
}

void ScenePainter::body(const SceneView& view, std::uint32_t number, const motion::Pose& pose) {
  const Color color = color_of(number);
  for (const scene::Part& part : parts_of(scene_.parts, number)) {
    const std::uint32_t up =
        part.shape == scene::Shape::die
            ? shapes::upper_face(math::composed(pose.orientation, part.orientation))
            : 0;
    for (const FlatPiece& piece : flat_pieces(scene_, part, pose, view.seen, {})) {
      if (piece.radius_mm > 0) {
        fill(view, piece, color);
        edge(view, piece, plot::palette::k_ink, 1);
        number_on(view, piece, number);
        continue;
      }
      fill(view, piece, piece.face == up ? k_ivory : k_shaded);
      for (const auto& pip : piece.pips_mm)
        polygon(view, pip, plot::palette::k_ink);
      edge(view, piece, color, 1.6);
    }
  }
}

void ScenePainter::fill(const SceneView& view, const FlatPiece& piece, const Color& color) {
  if (piece.radius_mm > 0) {
    panel_.series.push_back(plot::Disc{.center = view.at(piece.middle_mm),
                                       .radius_x = piece.radius_mm * view.px_per_mm,
                                       .color = color});
  } else {
    polygon(view, piece.corners_mm, color);
  }
}

void ScenePainter::edge(const SceneView& view, const FlatPiece& piece, const Color& color,
                        double width_px) {
  if (piece.radius_mm > 0) {
    panel_.series.push_back(plot::Disc{.center = view.at(piece.middle_mm),
                                       .radius_x = piece.radius_mm * view.px_per_mm,
                                       .color = color,
                                       .filled = false});
    return;
  }
  std::vector<Point> edges;
  for (const Point& corner : piece.corners_mm)
    edges.push_back(view.at(corner));
  line(closed(std::move(edges)), color, width_px);
}

/// Numbers bodies from 1 if the numbers are legible.
void ScenePainter::number_on(const SceneView& view, const FlatPiece& piece, std::uint32_t number) {
  if (scene_.bodies() == 1) return;
  const std::string words = std::to_string(number + 1);
  const double size_px = piece.radius_mm * view.px_per_mm * (words.size() < 3 ? 1.1 : 0.8);
  if (size_px < k_number_px_min) return;
  panel_.series.push_back(plot::Text{.at = view.at(piece.middle_mm),
                                     .text = words,
                                     .anchor = plot::Anchor::middle,
                                     .color = on_top_of(color_of(number)),
                                     .size_px = std::min(size_px, 22.0),
                                     .inside = true});
}

void ScenePainter::instant(const SceneView& view, double since_s, double time_s) {
  Bodies seen;
  for (const motion::Path& path : animation_.motion.paths()) {
    if (!path.enters()) continue;
    const double from_s = std::max(since_s, path.start_s());
    plot::Line track{.color = color_of(path.body()), .width_px = 1.2};
    for (std::size_t i = 0; from_s < time_s && i <= k_points_per_way; ++i) {
      const double share = static_cast<double>(i) / k_points_per_way;
      const auto centre_m = path.centre_at(from_s + (time_s - from_s) * share);
      const Point place_mm = centre_m ? projected_mm(*centre_m, view.seen) : Point{NAN, NAN};
      // Clip bodies that have left the scene, since they would cover other pictures.
      track.points.push_back(is_in(view, place_mm) ? view.at(place_mm) : Point{NAN, NAN});
    }
    if (!track.points.empty()) panel_.series.push_back(std::move(track));
    const auto pose = path.pose_at(time_s);
    if (pose && is_in(view, projected_mm(pose->centre_m, view.seen)))
      seen.emplace_back(*pose, path.body());
  }
  bodies(view, std::move(seen));
}

}  // namespace sleight::pictures
