// What a simulation starts from: bodies, static geometry, and how they meet.
//
// Units are SI; the world's frame is right-handed, and its axes are the user's choice (gravity says
// where down is). A scene is a plain value that its author fills in; Simulation::start checks it
// and answers with errors that name the body. Thread safety: a value.
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

/// A ball, or convex parts in the body's frame: origin at the centre of mass, principal axes along
/// x, y and z (mass_properties.h puts them there). Shared, so that bodies of one shape keep it
/// once.
using Shape = std::variant<Sphere, std::shared_ptr<const Compound>>;

/// Where and how a body enters.
struct StartState {
  Pose pose;
  Twist twist;
};

struct BodyDescription {
  std::string name;  ///< for errors; "body 7" if empty
  Shape shape;
  Inertia inertia;
  MaterialId material{};
  Tick start_tick{};
  StartState start;
  /// Another start for a body that would overlap something at its own: attempt 1, 2, ... up to
  /// k_start_attempts_max. A function of the attempt alone. Without it, an overlap is an error.
  std::function<StartState(std::uint32_t attempt)> start_again{};
  /// It starts at rest on what it touches, as a pin on its spot or a stone in an arch: at tick 0,
  /// without velocity, to within k_at_rest_gap_m of what is to carry it, in a scene in which bodies
  /// rest. Contact forces must hold all that starts so and hangs together, else the scene is
  /// refused. A blow or a moving supporter wakes it.
  bool rests = false;
};

/// All of space where dot(normal, x) < offset is solid.
struct StaticPlane {
  std::string name;
  HalfSpace outside;
  MaterialId material{};
  /// Its friction from place to place, in the place of the table's; shared, so that scenes of one
  /// plane keep it once.
  std::shared_ptr<const FrictionMap> friction_map{};
};

/// A convex body that doesn't move.
struct StaticConvex {
  std::string name;
  std::shared_ptr<const ConvexPolyhedron> polyhedron;  ///< in the world's frame
  MaterialId material{};
};

/// A surface of triangles that doesn't move. A closed one is solid on the side that its triangles'
/// normals leave; an open one is a sheet of no thickness that is met from both sides.
struct StaticMesh {
  std::string name;
  std::shared_ptr<const TriangleMesh> mesh;  ///< in the world's frame
  MaterialId material{};
  /// Bounding volumes allow for vertices that are moved by so much in each coordinate, between
  /// simulations (StaticGeometry::refresh). Changes no result.
  double slack_m = 0;
};

/// How slow contacts end. All 0: they never do, as in a gas.
struct SlowContacts {
  /// After an impact a pair separates at least this fast, if its energy allows it (restitution.h):
  /// a body in contact with another bounces at about this speed, some micrometres high.
  double separation_speed_mps = 0;
  /// A body rests when it was slower than this for `rest_time_s`, and touched only bodies of which
  /// this is true as well, resting ones, and static geometry. 0: bodies don't rest.
  double rest_speed_mps = 0;
  double rest_time_s = 0;
};

/// Speeds that suit bodies of size L, in units of v = sqrt(g L) and t = sqrt(L / g), the speed and
/// time of a fall by L / 2: bounces part at 0.01 v or more; a body rests below 0.08 v for 0.1 t.
inline SlowContacts slow_contacts_of(double size_m, double gravity_mps2) {
  const double fall_mps = std::sqrt(gravity_mps2 * size_m);
  return {.separation_speed_mps = 0.01 * fall_mps,
          .rest_speed_mps = 0.08 * fall_mps,
          .rest_time_s = 0.1 * std::sqrt(size_m / gravity_mps2)};
}

/// What suits heaps, walls and bumpy tables, where bodies tumble, rock and creep in many small
/// bounces: these may be three times as fast, 7 micrometres high for a die of 16 mm. A heap has
/// half as many events; a cube comes to rest aslant by up to 3e-3 rad in place of 1e-3.
inline SlowContacts coarse_slow_contacts_of(double size_m, double gravity_mps2) {
  SlowContacts slow = slow_contacts_of(size_m, gravity_mps2);
  slow.separation_speed_mps *= 3;
  return slow;
}

/// Something that a user or a script does to a body: its velocities jump.
struct Control {
  Tick tick{};
  BodyId body{};
  Vec3 velocity_change_mps = Vec3::Zero();
  Vec3 angular_velocity_change_radps = Vec3::Zero();
};

struct Scene {
  std::vector<BodyDescription> bodies;
  std::vector<StaticPlane> planes;
  std::vector<StaticConvex> convexes;
  std::vector<StaticMesh> meshes;
  std::vector<StaticSurface> surfaces;  ///< met by boxes only (shapes.h)
  ContactTable contacts;
  SlowContacts slow;
  Vec3 gravity_mps2 = Vec3::Zero();
  /// Lengths after which space repeats, 0 for an axis that doesn't. Only without static geometry.
  std::array<double, 3> period_m{};
  std::vector<Control> controls;  ///< in any order; at one tick, in the order given
};

/// Why a scene can't be simulated, or why a simulation stopped. The message names the body.
struct SceneError {
  enum class Kind : std::uint8_t {
    // What is wrong with the scene.
    bad_number,     ///< NaN, infinite, or out of its range
    bad_mass,       ///< zero, negative, or moments that no mass distribution has
    bad_shape,      ///< size, degenerate geometry
    bad_reference,  ///< a material or a body that doesn't exist
    no_balance,     ///< a body that is to start at rest isn't held
    overlap,        ///< at a start, also after all attempts
    // What the simulator could not do with a good scene: a bug, which the scene repeats.
    search_gave_up,       ///< a search for a collision examined too many ticks
    too_many_collisions,  ///< of one body, at one tick or in a millisecond
    impact_unresolved,    ///< no impulse was found
    spins_too_long,       ///< a body that touches nothing turns too fast for its fixed steps
    work_limit,           ///< more events than the caller allowed
    incomplete_history,   ///< a replay lacks what it must go on from: simulate everything
  };
  Kind kind{};
  std::string message;
};

/// The simulator's fault, and not the scene's.
inline bool is_failure(SceneError::Kind kind) {
  return kind > SceneError::Kind::overlap;
}

/// Why a body of this name can't start so; nothing if it can.
std::optional<SceneError> error_of_start(const StartState& start, const std::string& name);

}  // namespace sleight::physics
