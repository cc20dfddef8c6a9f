#include "worker/worlds/user_scene/build.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <variant>

#include "common/base/check.h"
#include "common/math/elementary.h"
#include "worker/physics/event/event.h"
#include "worker/physics/scene/static_geometries.h"
#include "worker/physics/scene/static_regions.h"

namespace sleight::worlds::user_scene {
namespace {

physics::MaterialId material_id(std::uint32_t material) {
  return {static_cast<std::uint8_t>(material)};
}
physics::CollisionGroup group_id(std::uint32_t group) {
  return {static_cast<std::uint8_t>(group)};
}

bool is_mesh(ShapeKind kind) {
  return kind == ShapeKind::mesh || kind == ShapeKind::helix || kind == ShapeKind::ramp;
}

/// Returns the least width of a body along the axes of its frame. Slow contacts depend on it.
double least_width_m(const physics::Shape& shape) {
  double least_m = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis)
    least_m =
        std::min(least_m, support_m(shape, Vec3::Unit(axis)) + support_m(shape, -Vec3::Unit(axis)));
  return least_m;
}

class Builder {
 public:
  explicit Builder(const SceneDescription& description) : description_(description) {}

  base::Result<BuiltScene, BuildError> build() {
    built_.scene.contacts = contact_table(description_.materials, description_.pairs);
    built_.scene.gravity_mps2 = description_.gravity_mps2;
    for (const auto& [a, b] : description_.no_contact)
      built_.scene.filter.set_meet(group_id(a), group_id(b), false);
    forms_.resize(description_.bodies.size());
    for (number_ = 0; number_ < description_.bodies.size(); ++number_) {
      if (auto error = make_form()) return BuildError{number_, std::move(*error)};
    }
    // Moving bodies come first, then fixed bodies, then other static objects.
    for_each_copy(ObjectKind::moving, [&](const Copy& copy) { add_body(copy, false); });
    built_.moving = static_cast<std::uint32_t>(built_.objects.size());
    for_each_copy(ObjectKind::fixed, [&](const Copy& copy) { add_body(copy, true); });
    built_.bodies = static_cast<std::uint32_t>(built_.objects.size());
    for_each_copy(ObjectKind::plane, [&](const Copy& copy) { add_plane(copy); });
    for_each_copy(ObjectKind::convex, [&](const Copy& copy) { add_convexes(copy); });
    for_each_copy(ObjectKind::mesh, [&](const Copy& copy) { add_mesh(copy); });
    if (error_) return std::move(*error_);
    built_.scene.slow = slow_contacts();
    built_.scene.noise = description_.noise;
    built_.scene.geometries = std::make_shared<const physics::StaticGeometries>();
    surround_all();
    return std::move(built_);
  }

 private:
  const BodyDescription& body() const { return description_.bodies[number_]; }

  ObjectKind kind_of(std::size_t number) const {
    const BodyDescription& body = description_.bodies[number];
    if (body.sizes.kind == ShapeKind::plane) return ObjectKind::plane;
    if (is_mesh(body.sizes.kind)) return ObjectKind::mesh;
    if (!body.is_static) return ObjectKind::moving;
    return forms_[number].rounds.empty() ? ObjectKind::convex : ObjectKind::fixed;
  }

  /// Makes the shape that all copies of the body share.
  std::optional<FormError> make_form() {
    const ShapeSizes& sizes = body().sizes;
    if (sizes.kind == ShapeKind::plane || is_mesh(sizes.kind)) return std::nullopt;
    const double density = description_.materials[body().material].density_kgpm3;
    auto made = body_form(sizes, body().parts, density);
    if (!made) return made.error();
    forms_[number_] = std::move(made).value();
    if (body().mass_kg)
      forms_[number_].inertia = with_mass(forms_[number_].inertia, *body().mass_kg);
    return std::nullopt;
  }

  template <class Add>
  void for_each_copy(ObjectKind kind, const Add& add) {
    for (number_ = 0; number_ < description_.bodies.size() && !error_; ++number_) {
      if (kind_of(number_) != kind) continue;
      shape_ = {};
      for (const Copy& copy : copies_of(body())) {
        built_.objects.push_back(
            {.name = copy.name, .kind = kind, .description = number_, .place = copy.place});
        add(copy);
      }
    }
  }

  void add_body(const Copy& copy, bool fixed) {
    const BodyForm& form = forms_[number_];
    if (!shape_) shape_ = form.shape(body().sizes);
    built_.objects.back().frame = form.frame;
    built_.objects.back().motion = {
        .velocity_mps = math::rotated(copy.turn, body().velocity_mps),
        .angular_velocity_radps = math::rotated(copy.turn, body().spin_radps)};
    built_.scene.bodies.push_back(
        {.name = copy.name,
         .shape = *shape_,
         .inertia = form.inertia,
         .material = material_id(body().material),
         .start_tick = physics::Tick{} + physics::ticks_after(body().start_s),
         .start = start_of(built_.objects.back()),
         .rests = body().rests,
         .fixed = fixed,
         .group = group_id(body().group)});
  }

  void add_plane(const Copy& copy) {
    const Vec3 normal = math::normalized(math::rotated(copy.place.orientation, Vec3::UnitZ()));
    std::shared_ptr<const physics::FrictionMap> map;
    if (!body().friction.empty()) {
      std::vector<physics::FrictionRectangle> rectangles;
      for (const FrictionPatch& patch : body().friction)
        rectangles.push_back({.u_min_m = patch.x_m[0],
                              .u_max_m = patch.x_m[1],
                              .v_min_m = patch.y_m[0],
                              .v_max_m = patch.y_m[1],
                              .friction = patch.friction});
      auto made =
          physics::FrictionMap::make({.origin_m = copy.place.position_m,
                                      .u = math::rotated(copy.place.orientation, Vec3::UnitX()),
                                      .v = math::rotated(copy.place.orientation, Vec3::UnitY())},
                                     std::move(rectangles));
      if (!made) return fail({"friction", made.error()});
      map = std::make_shared<const physics::FrictionMap>(std::move(made).value());
    }
    built_.objects.back().first = static_cast<std::uint32_t>(built_.scene.planes.size());
    built_.scene.planes.push_back(
        {.name = copy.name,
         .outside = {.normal = normal, .offset_m = math::dot(normal, copy.place.position_m)},
         .material = material_id(body().material),
         .friction_map = std::move(map),
         .group = group_id(body().group)});
  }

  void add_convexes(const Copy& copy) {
    const BodyForm& form = forms_[number_];
    const Pose pose = composed(copy.place, form.frame);
    built_.objects.back().first = static_cast<std::uint32_t>(built_.scene.convexes.size());
    built_.objects.back().count = static_cast<std::uint32_t>(form.polyhedra.size());
    for (const physics::ConvexPolyhedron& piece : form.polyhedra)
      built_.scene.convexes.push_back(
          {.name = copy.name,
           .polyhedron = std::make_shared<const physics::ConvexPolyhedron>(
               physics::moved(piece, math::matrix_of(pose.orientation), pose.position_m)),
           .material = material_id(body().material),
           .group = group_id(body().group)});
  }

  void add_mesh(const Copy& copy) {
    auto mesh = mesh_form(body().sizes, copy.place);
    if (!mesh) return fail(mesh.error());
    built_.objects.back().first = static_cast<std::uint32_t>(built_.scene.meshes.size());
    built_.scene.meshes.push_back(
        {.name = copy.name,
         .mesh = std::make_shared<const physics::TriangleMesh>(std::move(mesh).value()),
         .material = material_id(body().material),
         .group = group_id(body().group)});
  }

  void fail(FormError error) {
    if (!error_) error_ = BuildError{number_, std::move(error)};
  }

  void surround_all() {
    const auto surround = [&](const Vec3& point_m) {
      built_.low_m = built_.low_m.cwiseMin(point_m);
      built_.high_m = built_.high_m.cwiseMax(point_m);
    };
    for (const physics::BodyDescription& body : built_.scene.bodies) {
      const Vec3 around_m = Vec3::Constant(physics::reach_m(body.shape));
      surround(body.start.pose.position_m - around_m);
      surround(body.start.pose.position_m + around_m);
    }
    for (const physics::StaticConvex& convex : built_.scene.convexes)
      std::ranges::for_each(convex.polyhedron->vertices_m(), surround);
    for (const physics::StaticMesh& mesh : built_.scene.meshes)
      std::ranges::for_each(mesh.mesh->vertices_m(), surround);
  }

  physics::SlowContacts slow_contacts() const {
    double size_m = std::numeric_limits<double>::infinity();
    bool only_spheres = true;
    for (std::uint32_t body = 0; body < built_.moving; ++body) {
      const physics::Shape& shape = built_.scene.bodies[body].shape;
      size_m = std::min(size_m, least_width_m(shape));
      only_spheres = only_spheres && std::holds_alternative<physics::Sphere>(shape);
    }
    const double gravity_mps2 = math::norm(description_.gravity_mps2);
    physics::SlowContacts slow;
    if (built_.moving > 0 && gravity_mps2 > 0)
      slow = only_spheres ? physics::slow_contacts_of(size_m, gravity_mps2)
                          : physics::coarse_slow_contacts_of(size_m, gravity_mps2);
    return {.separation_speed_mps =
                description_.separation_speed_mps.value_or(slow.separation_speed_mps),
            .rest_speed_mps = description_.rest_speed_mps.value_or(slow.rest_speed_mps),
            .rest_time_s = description_.rest_time_s.value_or(slow.rest_time_s)};
  }

  const SceneDescription& description_;
  BuiltScene built_;
  std::vector<BodyForm> forms_;          ///< by body; empty for planes and meshes
  std::optional<physics::Shape> shape_;  ///< shared by the copies of a body
  std::uint32_t number_ = 0;             ///< the body being added
  std::optional<BuildError> error_;
};

/// A sheet's triangles are two features each.
std::size_t faces_of(const physics::TriangleMesh& mesh) {
  return (physics::is_closed(mesh) ? 1 : 2) * mesh.triangles().size();
}

}  // namespace

std::size_t count_of(const Copies& copies) {
  std::size_t count = 1;
  for (const std::uint32_t along : copies.count)
    count *= along;
  return count;
}

std::vector<Copy> copies_of(const BodyDescription& body) {
  const Copies& copies = body.copies;
  if (copies.kind == CopyKind::none) return {{.name = body.name, .place = body.place}};
  std::vector<Copy> all;
  const auto [nx, ny, nz] = copies.count;
  for (std::uint32_t i = 0; i < nx * ny * nz; ++i) {
    Copy copy{.name = fmt::format("{} {}", body.name, i + 1), .place = body.place};
    if (copies.kind == CopyKind::ring) {
      const double last = copies.full_circle ? nx : nx - 1;
      const double angle_rad =
          copies.from_rad + (nx > 1 ? (copies.to_rad - copies.from_rad) * (i / last) : 0);
      copy.turn = math::quaternion_of_rotation_vector({0, 0, angle_rad});
      copy.place.position_m += math::rotated(copy.turn, Vec3(copies.radius_m, 0, 0));
      copy.place.orientation = math::composed(copy.turn, copy.place.orientation);
    } else {
      const Vec3 steps =
          copies.kind == CopyKind::row ? Vec3(i, i, i) : Vec3(i % nx, (i / nx) % ny, i / (nx * ny));
      for (int axis = 0; axis < 3; ++axis)
        copy.place.position_m[axis] += steps[axis] * copies.step_m[axis];
    }
    all.push_back(std::move(copy));
  }
  return all;
}

physics::SurfaceLaw mean_law(const physics::SurfaceLaw& a, const physics::SurfaceLaw& b) {
  return {.restitution = 0.5 * (a.restitution + b.restitution),
          .friction = 0.5 * (a.friction + b.friction),
          .rolling_friction = 0.5 * (a.rolling_friction + b.rolling_friction)};
}

physics::StartState start_of(const Object& object) {
  const Vec3 centre_m = math::rotated(object.place.orientation, object.frame.position_m);
  physics::Twist twist = object.motion;
  twist.velocity_mps += math::cross(twist.angular_velocity_radps, centre_m);
  return {.pose = composed(object.place, object.frame), .twist = twist};
}

physics::ContactTable contact_table(std::span<const Material> materials,
                                    std::span<const PairLaw> pairs) {
  const auto count = static_cast<std::uint32_t>(materials.size());
  physics::ContactTable table(count);
  for (std::uint32_t a = 0; a < count; ++a) {
    for (std::uint32_t b = a; b < count; ++b)
      table.set(material_id(a), material_id(b), mean_law(materials[a].law, materials[b].law));
  }
  for (const PairLaw& pair : pairs)
    table.set(material_id(pair.materials[0]), material_id(pair.materials[1]), pair.law);
  return table;
}

double support_m(const physics::Shape& shape, const Vec3& direction) {
  if (const auto* sphere = std::get_if<physics::Sphere>(&shape)) return sphere->radius_m;
  const auto& compound = *std::get<std::shared_ptr<const physics::Compound>>(shape);
  double most_m = -std::numeric_limits<double>::infinity();
  for (const physics::ConvexPolyhedron& piece : compound.parts) {
    for (const Vec3& vertex_m : piece.vertices_m())
      most_m = std::max(most_m, math::dot(direction, vertex_m));
  }
  for (const physics::RoundPiece& piece : compound.round_parts)
    most_m = std::max(most_m, piece.reach_m(direction));
  return most_m;
}

base::Result<BuiltScene, BuildError> build(const SceneDescription& description) {
  return Builder(description).build();
}

StaticOwners::StaticOwners(const BuiltScene& built) {
  for (const physics::BodyDescription& body : built.scene.bodies)
    is_sphere_.push_back(std::holds_alternative<physics::Sphere>(body.shape));
  const auto extend = [](std::vector<Range>& ranges, std::size_t count, std::uint32_t object) {
    const std::uint32_t begin = ranges.empty() ? 0 : ranges.back().end;
    ranges.push_back({begin + static_cast<std::uint32_t>(count), object});
  };
  for (std::uint32_t object = built.bodies; object < built.objects.size(); ++object) {
    const Object& one = built.objects[object];
    for (std::uint32_t i = one.first; i < one.first + one.count; ++i) {
      numbered_.push_back(object);
      if (one.kind == ObjectKind::mesh) {
        const physics::TriangleMesh& mesh = *built.scene.meshes[i].mesh;
        extend(features_, faces_of(mesh) + mesh.edges().size() + mesh.vertices_m().size(), object);
        extend(pieces_, mesh.triangles().size(), object);
        continue;
      }
      std::size_t features = 1;
      if (one.kind == ObjectKind::convex) {
        const physics::ConvexPolyhedron& hull = *built.scene.convexes[i].polyhedron;
        features = hull.faces().size() + hull.edges().size() + hull.vertices_m().size();
      }
      extend(features_, features, object);
      extend(pieces_, 1, object);
    }
  }
}

std::uint32_t StaticOwners::owner(std::uint32_t body, physics::StaticId met) const {
  const std::vector<Range>& ranges = is_sphere_[body] ? features_ : pieces_;
  const auto at = std::ranges::upper_bound(ranges, met.value, {}, &Range::end);
  CHECK(at != ranges.end());
  return at->object;
}

std::uint32_t StaticOwners::met_by(const physics::Impact& impact) const {
  const bool is_static = (impact.higher & physics::k_static) != 0;
  return is_static ? numbered_[impact.higher & ~physics::k_static] : impact.higher;
}

}  // namespace sleight::worlds::user_scene
