// Makes the simulator's shape, mass and inertia from a shape's sizes.
//
// A request gives places in the shape's frame (description.h). The simulator needs the body's
// frame: origin in the centre of mass, principal axes along x, y, z. BodyForm::frame joins the two.
// Thread safety: pure functions and values.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "worker/physics/scene/scene.h"
#include "worker/worlds/user_scene/description.h"

namespace sleight::worlds::user_scene {

/// Why a shape can't be made. `key` is the request's key at fault. The message follows "'key' in
/// [[world.body]]: ".
struct FormError {
  std::string key;
  std::string message;
};

struct BodyForm {
  std::vector<physics::ConvexPolyhedron> polyhedra{};  ///< in the body's frame
  std::vector<physics::RoundPiece> rounds{};           ///< in the body's frame
  physics::Inertia inertia;
  Pose frame;            ///< the body's frame in the shape's frame
  double volume_m3 = 0;  ///< where parts of a compound overlap, it counts for each part

  /// The shape in the form that the simulator needs. A sphere is a physics::Sphere.
  physics::Shape shape(const ShapeSizes& sizes) const;
};

/// Makes the form of a solid: any kind except plane, mesh, helix and ramp. `parts` are those of a
/// compound, at least one.
base::Result<BodyForm, FormError> body_form(const ShapeSizes& sizes,
                                            std::span<const PartDescription> parts,
                                            double density_kgpm3);

/// Makes a mesh, helix or ramp in the frame in which the shape's frame has this pose.
base::Result<physics::TriangleMesh, FormError> mesh_form(const ShapeSizes& sizes, const Pose& pose);

/// Scales mass and moments.
physics::Inertia with_mass(physics::Inertia inertia, double mass_kg);

/// Returns the pose of `inner`'s frame in the frame in which `outer` is given.
Pose composed(const Pose& outer, const Pose& inner);
/// If `pose` is B's pose in A's frame, returns A's pose in B's frame.
Pose inverse(const Pose& pose);

}  // namespace sleight::worlds::user_scene
