// What an animation's things look like: bodies, what stands still, and what a request wants where.
// Enough to draw a run's animations without its world's code.
//
// A scene is a list of features: first the bodies, in the order of their numbers in motions
// (common/motion), then what doesn't move, then goals. A feature is drawn as its parts. Some look
// otherwise in each animation, which says how (Variation): vertices that are moved, parts of its
// own, the control points of a surface.
//
// Frame: right-handed, z up, SI; parts of bodies are in the body's frame, all others in the
// scene's. Thread safety: values.
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

/// In the order of k_kind_names.
enum class FeatureKind : std::uint8_t {
  body,    ///< moves
  fixed,   ///< bodies meet it, and it doesn't move
  wanted,  ///< a goal's place: bodies don't meet it
};
inline constexpr std::array<std::string_view, 3> k_kind_names{"body", "fixed", "wanted"};

/// In the order of k_shape_names; what Part::size_m says of each.
enum class Shape : std::uint8_t {
  sphere,   ///< x: the diameter
  box,      ///< its sides
  die,      ///< a box with pips: 1 on +x, 2 on +y, 3 on +z, opposite faces add up to 7
  disc,     ///< x: the diameter, about z; no thickness
  mesh,     ///< triangles
  ground,   ///< all below z = 0 of the part's frame, without end; x and y: what to draw of it
  surface,  ///< a B-spline surface (surface.h); x and y: its sides, z: spacing of control points
};
inline constexpr std::array<std::string_view, 7> k_shape_names{"sphere", "box",    "die",    "disc",
                                                               "mesh",   "ground", "surface"};

struct Part {
  std::uint32_t feature = 0;
  Shape shape = Shape::box;
  Vec3 size_m{0, 0, 0};
  Vec3 position_m{0, 0, 0};  ///< of its middle
  Quat orientation = Quat::Identity();
  // Of a mesh: its rows among the scene's triangles.
  std::uint32_t first_triangle = 0;
  std::uint32_t triangles = 0;
};

inline constexpr std::int32_t k_none = -1;

struct Feature {
  std::string name{};  ///< "die 3", "table": for people and for queries
  FeatureKind kind = FeatureKind::body;
  /// The first of the bodies that may take each other's place without making another animation;
  /// itself where there is none.
  std::uint32_t twin_of = 0;
  /// The body that a goal is for; none: any, or it is no goal.
  std::int32_t body = k_none;
};

struct Vertex {
  Vec3 place_m{0, 0, 0};  ///< in its part's frame
  /// The row of the animation's offsets that is added; none: it stays.
  std::int32_t offset = k_none;
};

struct Scene {
  std::vector<Feature> features{};
  std::vector<Part> parts{};  ///< ascending by feature
  std::vector<Vertex> vertices{};
  std::vector<std::array<std::uint32_t, 3>> triangles{};  ///< counter-clockwise seen from outside
  /// The variable of states that holds vertices' offsets, (vertex, xyz) in metres; empty: none.
  std::string offset_variable{};
  bool has_own_parts = false;   ///< animations have parts of their own
  bool has_own_points = false;  ///< animations have control points
  /// A box about all that bodies do, to look at.
  Vec3 low_m{0, 0, 0};
  Vec3 high_m{0, 0, 0};

  std::uint32_t bodies() const;
  std::optional<std::uint32_t> find(std::string_view name) const;
};

/// A control point of a surface: at (i, j) times the spacing.
struct ControlPoint {
  std::int32_t i = 0;
  std::int32_t j = 0;
  double height_m = 0;
  double restitution = 0;
  double friction = 0;
  friend bool operator==(const ControlPoint&, const ControlPoint&) = default;
};

/// What of a scene is an animation's own.
struct Variation {
  std::vector<Part> parts{};           ///< no meshes
  std::vector<ControlPoint> points{};  ///< ascending by (j, i); those that are needed
};

/// What is wrong with a scene that comes from a file; empty: nothing. Names are not empty and
/// unique, bodies come first, indices are in their ranges, numbers finite and rotations such.
std::string fault_of(const Scene& scene);
/// Likewise of an animation's own parts.
std::string fault_of_parts(std::span<const Part> parts, const Scene& scene);

}  // namespace sleight::scene
