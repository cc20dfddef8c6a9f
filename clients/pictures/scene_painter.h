// Draws a scene and its animations into a panel. Private to clients/pictures.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "clients/pictures/animation_figures.h"
#include "clients/pictures/scene_view.h"
#include "clients/plot/figure.h"

namespace sleight::pictures {

inline constexpr double k_figure_width_px = 1280;
inline constexpr double k_title_room_px = 9;  ///< below a panel's title
inline constexpr double k_caption_px = 18;    ///< above a view
inline constexpr double k_caption_size_px = 11.5;
inline constexpr double k_between_px = 12;  ///< between views

/// The visible extent in millimetres.
struct SceneExtent {
  math::Vec3 low_mm{1e300, 1e300, 1e300};
  math::Vec3 high_mm{-1e300, -1e300, -1e300};

  void add(const math::Vec3& place_mm, double around_mm);
  double width_mm() const { return high_mm.x() - low_mm.x(); }
  double depth_mm() const { return high_mm.y() - low_mm.y(); }
  double height_mm() const { return high_mm.z() - low_mm.z(); }
};

/// Returns the extent of all bodies' motions, of fixed things except the ground, and of goals.
SceneExtent extent_of(const scene::Scene& scene, const std::vector<ShownAnimation>& animations);

/// Whether all bodies move in planes of constant y, so that the view from the front is sufficient.
bool is_flat(const std::vector<ShownAnimation>& animations);

/// Maps a view of the scene to a panel.
struct SceneView {
  Seen seen;
  plot::Point origin;  ///< position of the scene's origin
  double px_per_mm = 1;

  plot::Point at(const plot::Point& place_mm) const {
    return {origin.x + px_per_mm * place_mm.x, origin.y + px_per_mm * place_mm.y};
  }
};

/// Returns the view that has the extent's lowest left corner at this point of the panel.
SceneView view_of(const SceneExtent& extent, Seen seen, const plot::Point& low_px,
                  double px_per_mm);

/// Returns an empty panel of this size for views of the scene.
plot::Panel empty_panel(const ShownAnimation& animation, double width_px, double height_px);

/// Returns equally spaced times from a body's entry until it rests (at most a few hundred), then
/// the time at rest. REQUIRES: the body enters.
std::vector<double> instants_of(const motion::Path& path);

class ScenePainter {
 public:
  /// Borrows all arguments.
  ScenePainter(const scene::Scene& scene, const SceneExtent& extent,
               const ShownAnimation& animation, plot::Panel& panel);

  void caption(const plot::Point& at, std::string words, plot::Anchor anchor = plot::Anchor::start);
  /// Draws fixed things and goals.
  void scenery(const SceneView& view);
  /// Draws the paths of all bodies, then the bodies at rest.
  void ways(const SceneView& view);
  /// Draws the bodies at one moment, with the paths of their centres since an earlier moment.
  void instant(const SceneView& view, double since_s, double time_s);

 private:
  void outline(const plot::Point& low, const plot::Point& high, const plot::Color& color,
               double width_px = 1.4);
  void line(std::vector<plot::Point> points, const plot::Color& color, double width_px);
  void polygon(const SceneView& view, const std::vector<plot::Point>& corners_mm,
               const plot::Color& color);
  void surface(const SceneView& view, const scene::Part& part);
  void ground(const SceneView& view, const scene::Part& part);
  void table_below(const SceneView& view, double z_mm);
  void fixed(const SceneView& view, const scene::Part& part);
  void wanted(const SceneView& view, const scene::Part& part);
  void way(const SceneView& view, const motion::Path& path);
  void outlines(const SceneView& view, std::uint32_t body, const motion::Pose& pose,
                const plot::Color& color);
  void body(const SceneView& view, std::uint32_t body, const motion::Pose& pose);
  using Bodies = std::vector<std::pair<motion::Pose, std::uint32_t>>;
  /// Draws the nearest bodies last.
  void bodies(const SceneView& view, Bodies seen);
  void fill(const SceneView& view, const FlatPiece& piece, const plot::Color& color);
  void edge(const SceneView& view, const FlatPiece& piece, const plot::Color& color,
            double width_px);
  void number_on(const SceneView& view, const FlatPiece& piece, std::uint32_t body);
  std::vector<plot::Point> clipped(const SceneView& view,
                                   std::vector<plot::Point> corners_mm) const;
  bool is_in(const SceneView& view, const plot::Point& place_mm) const;
  plot::Color color_of(std::uint32_t body) const;

  const scene::Scene& scene_;
  const SceneExtent& extent_;
  const ShownAnimation& animation_;
  plot::Panel& panel_;
};

}  // namespace sleight::pictures
