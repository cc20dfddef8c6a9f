// A physics scene, from which a simulation starts: bodies, static geometry and contact laws.
//
// Units are SI. The world's frame is right-handed; the user chooses its axes, and gravity defines
// which way is down. A scene is a plain value that its author fills in. Simulation::start checks
// the scene and returns errors that name the body. Thread safety: a value.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "worker/physics/collision/sphere_search.h"
#include "worker/physics/event/event.h"
#include "worker/physics/motion/rigid_body.h"
#include "worker/physics/scene/collision_filter.h"
#include "worker/physics/scene/contact_noise.h"
#include "worker/physics/scene/friction_map.h"
#include "worker/physics/scene/surface_law.h"
#include "worker/physics/shape/mass_properties.h"
#include "worker/physics/shape/shapes.h"
#include "worker/physics/shape/triangle_mesh.h"
#include "worker/physics/surface/surface_controls.h"

namespace sleight::physics {

struct Sphere {
  double radius_m = 0;
};

/// A ball, or convex parts in the body's frame. The body's frame has the centre of mass as origin
/// and the principal axes as x, y and z (mass_properties.h). Bodies of the same shape share their
/// parts.
using Shape = std::variant<Sphere, std::shared_ptr<const Compound>>;

/// Returns the radius of a ball about the centre of mass that contains the body. REQUIRES: a
/// compound isn't null.
inline double reach_m(const Shape& shape) {
  const auto* sphere = std::get_if<Sphere>(&shape);
  return sphere != nullptr ? sphere->radius_m
                           : std::get<std::shared_ptr<const Compound>>(shape)->r_outer_m();
}

struct StartState {
  Pose pose;
  Twist twist;
};

struct BodyDescription {
  std::string name;  ///< for error messages; "body 7" if empty
  Shape shape;
  Inertia inertia;
  MaterialId material{};
  Tick start_tick{};
  StartState start;
  /// If the body would overlap something at `start`, this function returns another start. Attempts
  /// are 1, 2, ... up to k_start_attempts_max. The result must depend only on the attempt. If the
  /// function isn't set, an overlap is an error.
  std::function<StartState(std::uint32_t attempt)> start_again{};
  /// The body starts at rest on what it touches, as a bowling pin or a stone in an arch does.
  /// REQUIRES: start_tick is 0, velocities are 0, the gaps to its supporters are at most
  /// k_at_rest_gap_m, and SlowContacts lets bodies rest. The scene is refused if contact forces
  /// can't hold all bodies that start at rest. An impact or a moving supporter wakes the body.
  bool rests = false;
  /// The body never moves: static geometry of any shape, such as a cylinder. It may overlap static
  /// geometry and other fixed bodies. Its inertia is ignored and needn't be valid. REQUIRES:
  /// start_tick is 0, velocities are 0, `rests` is false, start_again isn't set, no control acts on
  /// the body, and the scene isn't periodic.
  bool fixed = false;
  CollisionGroup group{};
};

/// A plane; all points x with dot(normal, x) < offset are solid.
struct StaticPlane {
  std::string name;
  HalfSpace outside;
  MaterialId material{};
  /// Varies with position, and replaces the contact table's friction. Scenes with the same plane
  /// share the map.
  std::shared_ptr<const FrictionMap> friction_map{};
  CollisionGroup group{};
};

struct StaticConvex {
  std::string name;
  std::shared_ptr<const ConvexPolyhedron> polyhedron;  ///< in the world's frame
  MaterialId material{};
  CollisionGroup group{};
};

/// A triangle surface that doesn't move. The normals of a closed mesh point away from the solid. An
/// open mesh is a sheet of zero thickness; bodies meet it from both sides.
struct StaticMesh {
  std::string name;
  std::shared_ptr<const TriangleMesh> mesh;  ///< in the world's frame
  MaterialId material{};
  /// Margin of the bounding volumes: each vertex coordinate may move by this much between
  /// simulations (StaticGeometry::refresh). The margin changes no result.
  double slack_m = 0;
  CollisionGroup group{};
};

/// Limits that end series of ever slower contacts. If all are 0, such series never end, as in a
/// gas.
struct SlowContacts {
  /// Minimum separation speed of a pair after an impact, if the pair's energy allows it
  /// (restitution.h). If a body lies on another, it bounces at about this speed, a few micrometres
  /// high.
  double separation_speed_mps = 0;
  /// To come to rest, a body must be slower than this for `rest_time_s`. Meanwhile the body must
  /// touch only static geometry, resting bodies, and bodies that are as slow. 0: bodies don't rest.
  double rest_speed_mps = 0;
  double rest_time_s = 0;
};

/// Returns limits for bodies of size L. With v = sqrt(g L) and t = sqrt(L / g), bodies separate at
/// 0.01 v or more. Bodies rest after being slower than 0.08 v for a time of 0.1 t. If a body falls
/// by L / 2, this takes the time t, and its speed becomes v.
inline SlowContacts slow_contacts_of(double size_m, double gravity_mps2) {
  const double fall_mps = std::sqrt(gravity_mps2 * size_m);
  return {.separation_speed_mps = 0.01 * fall_mps,
          .rest_speed_mps = 0.08 * fall_mps,
          .rest_time_s = 0.1 * std::sqrt(size_m / gravity_mps2)};
}

/// Returns limits for heaps, walls and bumpy tables, where bodies tumble, rock and creep in many
/// small bounces. The separation speed is three times that of slow_contacts_of: bounces are 7
/// micrometres high for a die of 16 mm. A heap has half as many events as with slow_contacts_of.
/// But a cube comes to rest tilted by up to 3e-3 rad instead of 1e-3.
inline SlowContacts coarse_slow_contacts_of(double size_m, double gravity_mps2) {
  SlowContacts slow = slow_contacts_of(size_m, gravity_mps2);
  slow.separation_speed_mps *= 3;
  return slow;
}

/// A sudden change of a body's velocities, made by a user or a script.
struct Control {
  Tick tick{};
  BodyId body{};
  Vec3 velocity_change_mps = Vec3::Zero();
  Vec3 angular_velocity_change_radps = Vec3::Zero();
};

class StaticGeometries;  // static_geometries.h

struct Scene {
  std::vector<BodyDescription> bodies;
  std::vector<StaticPlane> planes;
  std::vector<StaticConvex> convexes;
  std::vector<StaticMesh> meshes;
  std::vector<StaticSurface> surfaces;  ///< bodies that meet these must be boxes (shapes.h)
  ContactTable contacts;
  CollisionFilter filter;  ///< by default, everything meets
  SlowContacts slow;
  ContactNoise noise;  ///< by default, none
  Vec3 gravity_mps2 = Vec3::Zero();
  /// Space repeats with this period along each axis; 0: it doesn't repeat. REQUIRES: no static
  /// geometry and no fixed bodies.
  std::array<double, 3> period_m{};
  std::vector<Control> controls;  ///< in any order; controls of one tick apply in the order given
  /// Stores the static geometry that simulations build, for reuse by simulations of copies of this
  /// scene. Null: each simulation builds its own. REQUIRES: shared meshes don't change.
  std::shared_ptr<const StaticGeometries> geometries{};
};

/// The reason why a scene can't be simulated, or why a simulation stopped. The message names the
/// body.
struct SceneError {
  enum class Kind : std::uint8_t {
    // Errors in the scene.
    bad_number,     ///< NaN, infinite, or out of its range
    bad_mass,       ///< zero, negative, or moments that no mass distribution has
    bad_shape,      ///< size, degenerate geometry
    bad_reference,  ///< a material or a body that doesn't exist
    no_balance,     ///< contact forces can't hold a body that starts at rest
    overlap,        ///< at the start, after all attempts
    // The scene is valid, but the simulator failed. Such a failure is a bug; simulating the scene
    // again reproduces it.
    search_gave_up,       ///< a collision search examined too many ticks
    too_many_collisions,  ///< of one body, at one tick or in a millisecond
    impact_unresolved,    ///< no impulse was found
    spins_too_long,       ///< a body without contacts rotates too fast for its fixed steps
    work_limit,           ///< more events than the caller allowed
    incomplete_history,   ///< a replay lacks state that it needs: simulate everything
  };
  Kind kind{};
  std::string message;
};

/// Whether the simulator failed although the scene is valid.
inline bool is_failure(SceneError::Kind kind) {
  return kind > SceneError::Kind::overlap;
}

/// Returns why a body can't start in this state. Empty: the state is valid.
std::optional<SceneError> error_of_start(const StartState& start, const std::string& name);

}  // namespace sleight::physics
