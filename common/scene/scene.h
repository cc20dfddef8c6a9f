// A scene description: how bodies, fixed things and goals look. A viewer needs only this
// description to draw a run's animations, not the world's code.
//
// A scene is a list of features: first the bodies, in the order of their numbers in motions
// (common/motion), then fixed things, then goals. A feature is drawn as its parts. A Variation
// gives one animation additional parts, or the control points of a surface.
//
// Frame: right-handed, z up, SI. Parts of bodies are in the body's frame, and all other parts in
// the scene's frame. Thread safety: values.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/math/rotation.h"
#include "common/math/vector.h"

namespace sleight::scene {

using math::Quat;
using math::Vec3;

/// The kinds of features, in the order of k_kind_names.
enum class FeatureKind : std::uint8_t {
  body,    ///< moves
  fixed,   ///< doesn't move, but bodies collide with it
  wanted,  ///< a goal's place, without collisions
};
inline constexpr std::array<std::string_view, 3> k_kind_names{"body", "fixed", "wanted"};

/// The shapes of parts, in the order of k_shape_names. The comments define Part::size_m for each
/// shape.
enum class Shape : std::uint8_t {
  sphere,   ///< x: diameter
  box,      ///< x, y, z: sides
  die,      ///< a box with pips: 1 on +x, 2 on +y, 3 on +z, opposite faces add up to 7
  disc,     ///< x: diameter, about z; no thickness
  mesh,     ///< triangles
  ground,   ///< infinite, below z = 0 of the part's frame; x and y: drawn size
  surface,  ///< a B-spline surface (surface.h); x and y: sides, z: spacing of control points
};
inline constexpr std::array<std::string_view, 7> k_shape_names{"sphere", "box",    "die",    "disc",
                                                               "mesh",   "ground", "surface"};

struct Part {
  std::uint32_t feature = 0;
  Shape shape = Shape::box;
  Vec3 size_m{0, 0, 0};
  Vec3 position_m{0, 0, 0};  ///< of the part's middle
  Quat orientation = Quat::Identity();
  // For a mesh: the rows of the scene's triangles that belong to it.
  std::uint32_t first_triangle = 0;
  std::uint32_t triangles = 0;
};

inline constexpr std::int32_t k_none = -1;

struct Feature {
  std::string name{};  ///< for people and queries: "die 3", "table"
  FeatureKind kind = FeatureKind::body;
  /// Number of the first body that is interchangeable with this body. If there is no such body,
  /// this body's own number.
  std::uint32_t twin_of = 0;
  /// If the feature is a goal: the body that must reach it. None: any body may reach it, or the
  /// feature is not a goal.
  std::int32_t body = k_none;
};

struct Vertex {
  Vec3 place_m{0, 0, 0};  ///< in the part's frame
  /// The animation's offset in this row is added to the vertex. None: fixed.
  std::int32_t offset = k_none;
};

struct Scene {
  std::vector<Feature> features{};
  std::vector<Part> parts{};  ///< sorted by feature
  std::vector<Vertex> vertices{};
  std::vector<std::array<std::uint32_t, 3>> triangles{};  ///< counter-clockwise seen from outside
  /// Name of the states' variable that contains the vertices' offsets: (vertex, xyz), in metres.
  /// Empty: none.
  std::string offset_variable{};
  bool has_own_parts = false;   ///< animations have parts of their own
  bool has_own_points = false;  ///< animations have control points
  /// A box that contains all motion of bodies. Viewers choose a view by this box.
  Vec3 low_m{0, 0, 0};
  Vec3 high_m{0, 0, 0};

  std::uint32_t bodies() const;
  std::optional<std::uint32_t> find(std::string_view name) const;
};

/// A control point of a surface, at (i, j) times the spacing.
struct ControlPoint {
  std::int32_t i = 0;
  std::int32_t j = 0;
  double height_m = 0;
  double restitution = 0;
  double friction = 0;
  friend bool operator==(const ControlPoint&, const ControlPoint&) = default;
};

struct Variation {
  std::vector<Part> parts{};           ///< without meshes
  std::vector<ControlPoint> points{};  ///< the needed points, sorted by (j, i)
};

/// Returns the fault of a scene, which may come from an untrusted file. Empty: the scene is valid.
/// Checks that names are non-empty and unique, bodies come first, indices are in range, numbers are
/// finite and rotations valid.
std::string fault_of(const Scene& scene);
/// Like fault_of, for an animation's own parts.
std::string fault_of_parts(std::span<const Part> parts, const Scene& scene);

}  // namespace sleight::scene
