#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/physics/collision/surface_search.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/scene/static_geometries.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::physics {
namespace {

using Kind = SceneError::Kind;

/// Scenes beyond these limits are refused.
constexpr double k_speed_mps_max = 1e6;
constexpr double k_spin_radps_max = 1e6;
/// At this gravity, a falling body's speed grows by 1e-5 m/s per tick. Lasting contacts can still
/// be distinguished from impacts.
constexpr double k_gravity_mps2_max = 1e4;
constexpr double k_tilt_sd_rad_max = 0.5;
constexpr double k_mass_kg_min = 1e-12;
constexpr double k_mass_kg_max = 1e12;
constexpr double k_surface_spacing_m_min = 1e-3;
constexpr double k_rest_time_s_min = 1e-6;
constexpr double k_rest_time_s_max = 1e6;

bool within(const Vec3& v, double limit) {
  // Comparisons with NaN are false.
  return std::fabs(v.x()) <= limit && std::fabs(v.y()) <= limit && std::fabs(v.z()) <= limit;
}

std::optional<SceneError> error(Kind kind, std::string message) {
  return SceneError{kind, std::move(message)};
}

std::optional<SceneError> error_of_shape(const BodyDescription& body, const std::string& name) {
  const auto* sphere = std::get_if<Sphere>(&body.shape);
  if (sphere == nullptr) {
    const auto& compound = std::get<std::shared_ptr<const Compound>>(body.shape);
    if (!compound || compound->size() == 0) {
      return error(Kind::bad_shape, fmt::format("{}: the shape has no parts", name));
    }
    for (std::size_t part = 0; part < compound->parts.size(); ++part) {
      if (!compound->parts[part].vertices_m().empty()) continue;
      return error(Kind::bad_shape, fmt::format("{}: part {} has no vertices", name, part));
    }
    for (std::size_t part = 0; part < compound->round_parts.size(); ++part) {
      if (!compound->round_parts[part].features().empty()) continue;
      return error(Kind::bad_shape, fmt::format("{}: part {} has neither rings nor balls", name,
                                                compound->parts.size() + part));
    }
  }
  const double radius_m = reach_m(body.shape);
  if (!(radius_m > 10 * k_touch_m && radius_m <= k_coordinate_m_max)) {
    return error(Kind::bad_shape, fmt::format("{}: radius is {} m, expected {} to {} m", name,
                                              radius_m, 10 * k_touch_m, k_coordinate_m_max));
  }
  return std::nullopt;
}

std::optional<SceneError> error_of_mass(const Inertia& inertia, const std::string& name) {
  if (!(inertia.mass_kg >= k_mass_kg_min && inertia.mass_kg <= k_mass_kg_max)) {
    return error(Kind::bad_mass, fmt::format("{}: mass is {} kg, expected {} to {} kg", name,
                                             inertia.mass_kg, k_mass_kg_min, k_mass_kg_max));
  }
  if (inertia.symmetry != InertiaSymmetry::spherical &&
      inertia.symmetry != InertiaSymmetry::axial && inertia.symmetry != InertiaSymmetry::general) {
    return error(Kind::bad_mass, fmt::format("{}: unknown inertia symmetry {}", name,
                                             static_cast<int>(inertia.symmetry)));
  }
  const Vec3& moments = inertia.principal_kgm2;
  if (!within(moments, std::numeric_limits<double>::max()) ||
      !(moments.x() > 0 && moments.y() > 0 && moments.z() > 0)) {
    return error(
        Kind::bad_mass,
        fmt::format("{}: moments of inertia are {}, {}, {} kg m^2, expected finite numbers above 0",
                    name, moments.x(), moments.y(), moments.z()));
  }
  const bool axial = moments.x() == moments.y();
  const bool spherical = axial && moments.x() == moments.z();
  if ((inertia.symmetry == InertiaSymmetry::spherical && !spherical) ||
      (inertia.symmetry == InertiaSymmetry::axial && !axial)) {
    return error(
        Kind::bad_mass,
        fmt::format(
            "{}: the declared symmetry needs equal moments of inertia, found {}, {}, {} kg m^2",
            name, moments.x(), moments.y(), moments.z()));
  }
  return std::nullopt;
}

/// Checks that the body's shape can have these moments with some mass distribution. REQUIRES: no
/// error_of_shape and no error_of_mass.
std::optional<SceneError> error_of_moments(const BodyDescription& body, const std::string& name) {
  const Inertia& inertia = body.inertia;
  const Vec3& moments = inertia.principal_kgm2;
  // For any mass distribution, no moment exceeds the sum of the other two.
  const double sum = (moments.x() + moments.y()) + moments.z();
  const double largest = std::max({moments.x(), moments.y(), moments.z()});
  if (largest > (sum - largest) * (1 + 1e-9)) {
    return error(Kind::bad_mass, fmt::format("{}: moments of inertia are {}, {}, {} kg m^2; the "
                                             "largest exceeds the sum of the other two",
                                             name, moments.x(), moments.y(), moments.z()));
  }
  if (std::holds_alternative<Sphere>(body.shape) &&
      (inertia.symmetry != InertiaSymmetry::spherical)) {
    return error(
        Kind::bad_mass,
        fmt::format(
            "{}: a sphere needs spherical inertia (three equal moments), found {}, {}, {} kg m^2",
            name, moments.x(), moments.y(), moments.z()));
  }
  // All points of the body are within the radius of its centre.
  const double radius_m = reach_m(body.shape);
  const double most_kgm2 = inertia.mass_kg * radius_m * radius_m;
  const double least_kgm2 = std::min({moments.x(), moments.y(), moments.z()});
  if (!(moments.maxCoeff() <= most_kgm2 * (1 + 1e-9) && least_kgm2 >= 1e-9 * most_kgm2)) {
    return error(Kind::bad_mass, fmt::format("{}: moments of inertia are {}, {}, {} kg m^2; this "
                                             "mass and radius allow {} to {} kg m^2",
                                             name, moments.x(), moments.y(), moments.z(),
                                             1e-9 * most_kgm2, most_kgm2));
  }
  return std::nullopt;
}

std::optional<SceneError> error_of_group(CollisionGroup group, const std::string& name) {
  if (group.value < k_groups_max) return std::nullopt;
  return error(Kind::bad_reference, fmt::format("{}: group is {}, expected 0 to {}", name,
                                                group.value, k_groups_max - 1));
}

std::optional<SceneError> error_of_body(const Scene& scene, const BodyDescription& body,
                                        const std::string& name) {
  if (auto error = error_of_shape(body, name)) return error;
  if (!body.fixed) {
    if (auto error = error_of_mass(body.inertia, name)) return error;
    if (auto error = error_of_moments(body, name)) return error;
  }
  if (auto error = error_of_group(body.group, name)) return error;
  if (body.material.value >= scene.contacts.materials()) {
    return error(Kind::bad_reference,
                 fmt::format("{}: material is {}, but the number of materials is {}", name,
                             body.material.value, scene.contacts.materials()));
  }
  if (body.start_tick < Tick{} || body.start_tick > k_tick_max) {
    return error(Kind::bad_number, fmt::format("{}: start tick is {}, expected 0 to {}", name,
                                               body.start_tick.value, k_tick_max.value));
  }
  if (body.rests || body.fixed) {
    const Twist& twist = body.start.twist;
    const char* const lacks =
        body.start_tick != Tick{} ? "the start tick must be 0"
        : !is_zero(twist.velocity_mps) || !is_zero(twist.angular_velocity_radps)
            ? "the velocities must be 0"
        : body.fixed && body.rests         ? "it can't also be a body that starts at rest"
        : body.fixed && body.start_again   ? "it can't have other starts (start_again)"
        : body.fixed                       ? nullptr
        : !(scene.slow.rest_speed_mps > 0) ? "the scene must have rest_speed_mps > 0 (SlowContacts)"
        : is_zero(scene.gravity_mps2)      ? "gravity must not be 0"
                                           : nullptr;
    if (lacks != nullptr)
      return error(Kind::bad_number, fmt::format("{}: the body can't {}: {}", name,
                                                 body.fixed ? "be fixed" : "start at rest", lacks));
  }
  return error_of_start(body.start, name);
}

std::optional<SceneError> error_of_laws(const ContactTable& contacts) {
  for (std::size_t a = 0; a < contacts.materials(); ++a) {
    for (std::size_t b = a; b < contacts.materials(); ++b) {
      const SurfaceLaw& law =
          contacts.between({static_cast<std::uint8_t>(a)}, {static_cast<std::uint8_t>(b)});
      const std::string pair = fmt::format("materials {} and {}", a, b);
      if (!(law.restitution >= 0 && law.restitution <= 1)) {
        return error(Kind::bad_number,
                     fmt::format("{}: restitution is {}, expected 0 to 1", pair, law.restitution));
      }
      if (!(law.friction >= 0 && law.friction <= 1e6)) {
        return error(Kind::bad_number,
                     fmt::format("{}: friction is {}, expected 0 to 1e6", pair, law.friction));
      }
      if (!(law.rolling_friction >= 0 && law.rolling_friction <= 1)) {
        return error(Kind::bad_number, fmt::format("{}: rolling friction is {}, expected 0 to 1",
                                                   pair, law.rolling_friction));
      }
    }
  }
  return std::nullopt;
}

std::optional<SceneError> error_of_vertices(std::span<const Vec3> vertices_m,
                                            const std::string& name) {
  for (std::size_t v = 0; v < vertices_m.size(); ++v) {
    const Vec3& p = vertices_m[v];
    if (within(p, k_coordinate_m_max)) continue;
    return error(Kind::bad_number,
                 fmt::format("{}: vertex {} is at ({}, {}, {}) m; coordinates must be at most {} m",
                             name, v, p.x(), p.y(), p.z(), k_coordinate_m_max));
  }
  return std::nullopt;
}

template <class Static>
std::optional<SceneError> error_of_owner(const Scene& scene, const Static& one,
                                         const std::string& name) {
  const MaterialId material = one.material;
  if (material.value < scene.contacts.materials()) return error_of_group(one.group, name);
  return error(Kind::bad_reference,
               fmt::format("{}: material is {}, but the number of materials is {}", name,
                           material.value, scene.contacts.materials()));
}

std::optional<SceneError> error_of_noise(const ContactNoise& noise) {
  if (!noise.is_on()) return std::nullopt;
  const bool valid = noise.above_mps > 0 && noise.above_mps <= k_speed_mps_max &&
                     noise.tilt_sd_rad >= 0 && noise.tilt_sd_rad <= k_tilt_sd_rad_max &&
                     noise.restitution_sd >= 0 && noise.restitution_sd <= 1;
  if (valid) return std::nullopt;
  return error(
      Kind::bad_number,
      fmt::format("contact noise is above {} m/s with deviations of {} rad and {}; "
                  "expected a speed above 0, at most {} rad, and at most 1",
                  noise.above_mps, noise.tilt_sd_rad, noise.restitution_sd, k_tilt_sd_rad_max));
}

std::optional<SceneError> error_of_statics(const Scene& scene) {
  // If the scene's geometry is kept, its vertices were valid.
  const bool is_known = scene.geometries && scene.geometries->has(scene);
  for (std::size_t i = 0; i < scene.planes.size(); ++i) {
    const StaticPlane& plane = scene.planes[i];
    const std::string name = name_of_static("plane", plane.name, i);
    const double length = within(plane.outside.normal, 2) ? math::norm(plane.outside.normal) : 0;
    if (!(std::fabs(length - 1) < 1e-12) ||
        !(std::fabs(plane.outside.offset_m) <= k_coordinate_m_max)) {
      return error(
          Kind::bad_shape,
          fmt::format("{}: the normal must have length 1, and the offset must be at most {} m",
                      name, k_coordinate_m_max));
    }
    if (auto wrong = error_of_owner(scene, plane, name)) return wrong;
    if (!plane.friction_map) continue;
    const MapFrame& frame = plane.friction_map->frame();
    if (std::fabs(math::dot(frame.u, plane.outside.normal)) > 1e-9 ||
        std::fabs(math::dot(frame.v, plane.outside.normal)) > 1e-9) {
      return error(Kind::bad_shape,
                   fmt::format("{}: the axes of the friction map must lie in the plane", name));
    }
  }
  for (std::size_t i = 0; i < scene.convexes.size(); ++i) {
    const StaticConvex& convex = scene.convexes[i];
    const std::string name = name_of_static("convex", convex.name, i);
    if (!convex.polyhedron || convex.polyhedron->vertices_m().empty()) {
      return error(Kind::bad_shape, fmt::format("{}: the solid has no vertices", name));
    }
    if (!is_known) {
      if (auto wrong = error_of_vertices(convex.polyhedron->vertices_m(), name)) return wrong;
    }
    if (auto wrong = error_of_owner(scene, convex, name)) return wrong;
  }
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    const StaticMesh& mesh = scene.meshes[i];
    const std::string name = name_of_static("mesh", mesh.name, i);
    if (!mesh.mesh || mesh.mesh->triangles().empty()) {
      return error(Kind::bad_shape, fmt::format("{}: the mesh has no triangles", name));
    }
    if (!is_known) {
      if (auto wrong = error_of_vertices(mesh.mesh->vertices_m(), name)) return wrong;
    }
    if (auto wrong = error_of_owner(scene, mesh, name)) return wrong;
  }
  return std::nullopt;
}

std::optional<SceneError> error_of_surfaces(const Scene& scene) {
  for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
    const StaticSurface& surface = scene.surfaces[i];
    const std::string name = name_of_static("surface", surface.name, i);
    if (!surface.controls)
      return error(Kind::bad_shape, fmt::format("{}: the surface has no control points", name));
    // Comparisons with NaN are false. If a table is as wide as a scene, all its points can still be
    // numbered at the minimum spacing.
    if (!(surface.spacing_m >= k_surface_spacing_m_min &&
          surface.spacing_m <= k_coordinate_m_max)) {
      return error(Kind::bad_number,
                   fmt::format("{}: spacing is {} m, expected {} to {} m", name, surface.spacing_m,
                               k_surface_spacing_m_min, k_coordinate_m_max));
    }
    if (!(surface.point_spacing_m > 0)) {
      return error(Kind::bad_number,
                   fmt::format("{}: point spacing is {} m, expected a number above 0", name,
                               surface.point_spacing_m));
    }
    if (auto wrong = error_of_group(surface.group, name)) return wrong;
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
      const BodyDescription& body = scene.bodies[b];
      if (body.fixed || !scene.filter.meet(body.group, surface.group)) continue;
      const auto* compound = std::get_if<std::shared_ptr<const Compound>>(&body.shape);
      const bool boxes = compound != nullptr && (*compound)->round_parts.empty() &&
                         std::ranges::all_of((*compound)->parts, [&](const ConvexPolyhedron& part) {
                           return BoxLattice::of(part.view(), surface.point_spacing_m).has_value();
                         });
      if (boxes) continue;
      return error(Kind::bad_shape, fmt::format("body {}: this shape can't collide with {}; use "
                                                "boxes with at most {} points per side",
                                                b, name, BoxLattice::k_steps_max));
    }
  }
  return std::nullopt;
}

std::optional<SceneError> error_of_slow(const SlowContacts& slow) {
  const auto wrong = [](std::string_view what, double value, std::string_view range) {
    return error(Kind::bad_number,
                 fmt::format("slow contacts: {} is {}, expected {}", what, value, range));
  };
  // Comparisons with NaN are false.
  if (!(slow.separation_speed_mps >= 0 && slow.separation_speed_mps <= k_speed_mps_max))
    return wrong("separation speed", slow.separation_speed_mps,
                 fmt::format("0 (off) to {} m/s", k_speed_mps_max));
  if (!(slow.rest_speed_mps >= 0 && slow.rest_speed_mps <= k_speed_mps_max))
    return wrong("rest speed", slow.rest_speed_mps,
                 fmt::format("0 (bodies never rest) to {} m/s", k_speed_mps_max));
  if (slow.rest_speed_mps > 0 &&
      !(slow.rest_time_s >= k_rest_time_s_min && slow.rest_time_s <= k_rest_time_s_max)) {
    return wrong("rest time", slow.rest_time_s,
                 fmt::format("{} to {} s", k_rest_time_s_min, k_rest_time_s_max));
  }
  return std::nullopt;
}

std::optional<SceneError> error_of_period(const Scene& scene) {
  for (const double period : scene.period_m) {
    if (period == 0) continue;
    if (!(period > 0 && period <= k_coordinate_m_max)) {
      return error(
          Kind::bad_number,
          fmt::format(
              "period: expected a length above 0, or 0 for a scene that isn't periodic; found {} m",
              period));
    }
    if (!scene.planes.empty() || !scene.convexes.empty() || !scene.meshes.empty() ||
        !scene.surfaces.empty() || scene.gravity_mps2 != Vec3::Zero() ||
        std::ranges::any_of(scene.bodies, &BodyDescription::fixed)) {
      return error(
          Kind::bad_number,
          "a periodic scene can have neither gravity nor static geometry nor fixed bodies");
    }
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      const auto* sphere = std::get_if<Sphere>(&scene.bodies[i].shape);
      if (sphere == nullptr) {
        return error(Kind::bad_shape,
                     fmt::format("body {}: only spheres are allowed in a periodic scene", i));
      }
      const double radius_m = sphere->radius_m;
      if (period < 10 * radius_m) {
        return error(Kind::bad_shape, fmt::format("body {}: radius is {} m, but the period is {} "
                                                  "m; the period must be at least ten radii",
                                                  i, radius_m, period));
      }
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<SceneError> error_of_start(const StartState& start, const std::string& name) {
  if (!within(start.pose.position_m, k_coordinate_m_max)) {
    return error(
        Kind::bad_number,
        fmt::format("{}: start position is ({}, {}, {}) m; coordinates must be at most {} m", name,
                    start.pose.position_m.x(), start.pose.position_m.y(), start.pose.position_m.z(),
                    k_coordinate_m_max));
  }
  if (!within(start.twist.velocity_mps, k_speed_mps_max)) {
    return error(
        Kind::bad_number,
        fmt::format("{}: start velocity is ({}, {}, {}) m/s; components must be at most {} m/s",
                    name, start.twist.velocity_mps.x(), start.twist.velocity_mps.y(),
                    start.twist.velocity_mps.z(), k_speed_mps_max));
  }
  if (!within(start.twist.angular_velocity_radps, k_spin_radps_max)) {
    return error(
        Kind::bad_number,
        fmt::format(
            "{}: start angular velocity is ({}, {}, {}) rad/s; components must be at most {} rad/s",
            name, start.twist.angular_velocity_radps.x(), start.twist.angular_velocity_radps.y(),
            start.twist.angular_velocity_radps.z(), k_spin_radps_max));
  }
  const Quat& q = start.pose.orientation;
  const double norm2 = ((q.w() * q.w() + q.x() * q.x()) + q.y() * q.y()) + q.z() * q.z();
  if (!(std::fabs(norm2 - 1) < 1e-6)) {
    return error(Kind::bad_number,
                 fmt::format("{}: orientation has squared norm {}, expected a unit quaternion",
                             name, norm2));
  }
  return std::nullopt;
}

std::optional<SceneError> error_of(const Scene& scene) {
  if (!within(scene.gravity_mps2, k_gravity_mps2_max)) {
    return error(Kind::bad_number,
                 fmt::format("gravity is ({}, {}, {}) m/s^2; components must be at most {} m/s^2",
                             scene.gravity_mps2.x(), scene.gravity_mps2.y(), scene.gravity_mps2.z(),
                             k_gravity_mps2_max));
  }
  if (auto wrong = error_of_slow(scene.slow)) return wrong;
  if (auto wrong = error_of_laws(scene.contacts)) return wrong;
  if (auto wrong = error_of_noise(scene.noise)) return wrong;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const BodyDescription& body = scene.bodies[i];
    const std::string name =
        body.name.empty() ? fmt::format("body {}", i) : fmt::format("body '{}'", body.name);
    if (auto wrong = error_of_body(scene, body, name)) return wrong;
  }
  if (auto wrong = error_of_statics(scene)) return wrong;
  if (auto wrong = error_of_surfaces(scene)) return wrong;
  for (const Control& control : scene.controls) {
    if (control.body.value >= scene.bodies.size()) {
      return error(Kind::bad_reference,
                   fmt::format("a control acts on body {}, but the number of bodies is {}",
                               control.body.value, scene.bodies.size()));
    }
    if (scene.bodies[control.body].fixed) {
      return error(Kind::bad_reference,
                   fmt::format("a control acts on body {}, which is fixed", control.body.value));
    }
    if (control.tick < Tick{} || !within(control.velocity_change_mps, k_speed_mps_max) ||
        !within(control.angular_velocity_change_radps, k_spin_radps_max)) {
      return error(
          Kind::bad_number,
          fmt::format("the control of body {} at tick {} is invalid; expected a tick of at "
                      "least 0 and valid velocities",
                      control.body.value, control.tick.value));
    }
  }
  return error_of_period(scene);
}

}  // namespace sleight::physics
