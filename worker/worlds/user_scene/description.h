// A user's scene as a request describes it: bodies, static things and materials, before it is
// built.
//
// Frames. The world's frame is right-handed; gravity defines which way is down. Each shape has a
// frame of its own, which its user sees:
//   - sphere, box, rounded box, capsule, cylinder: The origin is the shape's middle. The axis of a
//     capsule or cylinder is z.
//   - cone: The origin is the middle of the axis, z. The tip is at z = +length/2.
//   - pin: The origin is the middle of the foot. The axis is z.
//   - hull, compound, mesh: The frame is that of the points or parts.
//   - plane: The origin is a point of the plane, and +z is its free side.
//   - helix and ramp: A channel is a half pipe, open above: the lower half of a circle, swept along
//     a middle line. Its mesh is a sheet of zero thickness, which bodies meet from both sides. A
//     helix's middle line begins at (path_radius, 0, 0) and turns about the z axis; it ends `drop`
//     below its beginning. A ramp's leads from (0, 0, 0) to (length, 0, -drop). The circle's plane
//     contains z and is perpendicular to the middle line seen from above. So the channel is lowest
//     exactly below its middle line, by the circle's radius.
// A body's place is its shape's origin in the world, and its turn rotates the shape's frame. The
// centre of mass and the principal axes appear only inside (body_form.h).
//
// Units are SI. Thread safety: values.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "worker/physics/motion/rigid_body.h"
#include "worker/physics/scene/scene.h"

namespace sleight::worlds::user_scene {

using physics::Pose;
using physics::Quat;
using physics::Vec3;

/// Limits of a scene, copies included.
inline constexpr std::size_t k_objects_max = 1000;
inline constexpr std::size_t k_materials_max = 64;
using physics::k_groups_max;
inline constexpr std::size_t k_parts_max = 64;
/// Maximum triangles of all meshes and channels together.
inline constexpr std::size_t k_mesh_triangles_max = 200'000;

enum class ShapeKind : std::uint8_t {
  sphere,
  box,
  capsule,
  cylinder,
  cone,
  rounded_box,
  pin,
  hull,
  compound,
  plane,
  mesh,
  helix,
  ramp,
};
inline constexpr std::size_t k_shape_kinds = 13;

/// The sizes of a shape. Each kind uses only some of them (request_body.cpp has the table).
struct ShapeSizes {
  ShapeKind kind = ShapeKind::sphere;
  double radius_m = 0;           ///< also the radius of a channel's cross-section
  double length_m = 0;           ///< along the axis, ends included; of a ramp: from end to end
  double edge_m = 0;             ///< radius of rounded edges
  Vec3 size_m = Vec3::Zero();    ///< sides of a box
  std::vector<Vec3> points_m{};  ///< of a hull or mesh
  std::vector<std::array<std::uint32_t, 3>> triangles{};  ///< of a mesh: indices of points
  bool closed = false;                                    ///< of a mesh: it must enclose a solid
  // Channels.
  double path_radius_m = 0;  ///< of a helix: from its axis to the channel's middle
  double drop_m = 0;         ///< height lost from the channel's start to its end
  double turns = 0;          ///< of a helix; anticlockwise if positive
  std::uint32_t steps = 0;   ///< sections along the channel
  std::uint32_t strips = 0;  ///< strips across the channel
};

/// A part of a compound.
struct PartDescription {
  ShapeSizes sizes;
  Pose pose{};                            ///< of the part's frame in the compound's frame
  std::optional<double> density_kgpm3{};  ///< default: the body's
};

enum class CopyKind : std::uint8_t { none, row, grid, ring };

/// Copies of a body. They are named "NAME 1", "NAME 2" and so on. A grid counts along x first, then
/// y, then z.
struct Copies {
  CopyKind kind = CopyKind::none;
  std::array<std::uint32_t, 3> count{1, 1, 1};  ///< a row or ring uses only the first
  Vec3 step_m = Vec3::Zero();                   ///< from one copy of a row or grid to the next
  double radius_m = 0;                          ///< of a ring about the z axis through the place
  double from_rad = 0;                          ///< angle of a ring's first copy, from x
  double to_rad = 0;  ///< angle of a ring's last copy; a full circle leaves this place out
  bool full_circle = true;
};

/// A rectangle of a plane with friction of its own, in the plane's frame.
struct FrictionPatch {
  std::array<double, 2> x_m{};  ///< from, to
  std::array<double, 2> y_m{};
  double friction = 0;
};

struct BodyDescription {
  std::string name;
  ShapeSizes sizes;
  std::vector<PartDescription> parts{};  ///< of a compound
  bool is_static = false;
  std::uint32_t material = 0;       ///< index in SceneDescription::materials
  std::uint32_t group = 0;          ///< index in SceneDescription::groups
  std::optional<double> mass_kg{};  ///< default: the material's density times the volume
  Pose place{};
  Vec3 velocity_mps = Vec3::Zero();  ///< of the shape's origin
  Vec3 spin_radps = Vec3::Zero();
  double start_s = 0;
  bool rests = false;
  Copies copies{};
  std::vector<FrictionPatch> friction{};  ///< of a plane
  std::uint32_t line = 0;                 ///< in the request, for errors; 0: unknown
};

struct Material {
  std::string name;
  double density_kgpm3 = 1000;
  physics::SurfaceLaw law{.restitution = 0.5, .friction = 0.3, .rolling_friction = 0};
};

/// The law between two materials. Pairs without such an entry have the mean of both materials' own
/// numbers.
struct PairLaw {
  std::array<std::uint32_t, 2> materials{};
  physics::SurfaceLaw law;
};

struct SceneDescription {
  double end_s = 10;
  Vec3 gravity_mps2{0, 0, -9.81};
  std::vector<Material> materials;  ///< at least one
  std::vector<PairLaw> pairs;
  std::vector<std::string> groups;                       ///< at least one
  std::vector<std::array<std::uint32_t, 2>> no_contact;  ///< pairs of groups that never meet
  /// Limits of slow contacts; each default follows from the bodies (build.h).
  std::optional<double> separation_speed_mps{};
  std::optional<double> rest_speed_mps{};
  std::optional<double> rest_time_s{};
  /// Its `values` are null: a state has them.
  physics::ContactNoise noise{};
  std::vector<BodyDescription> bodies;

  bool has_noise() const { return noise.above_mps > 0; }
};

}  // namespace sleight::worlds::user_scene
