#include "worker/worlds/user_scene/look/look.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "common/math/elementary.h"
#include "worker/physics/scene/static_regions.h"
#include "worker/physics/shape/round_solids.h"
#include "worker/worlds/scene_parts/scene_parts.h"
#include "worker/worlds/segments/recorded_segments.h"

namespace sleight::worlds::user_scene {
namespace {

using std::numbers::pi;

/// A part with a smaller share of its body's triangles is a box: 24 triangles are three rings of
/// four corners.
constexpr std::uint32_t k_share_min = 24;

void place(scene::Part& part, const Pose& pose) {
  const Pose placed =
      composed(pose, {.position_m = part.position_m, .orientation = part.orientation});
  part.position_m = placed.position_m;
  part.orientation = placed.orientation;
}

/// Returns the form's furthest point in the direction `u`, in the body's frame.
Vec3 furthest_m(const BodyForm& form, const Vec3& u) {
  Vec3 furthest = Vec3::Zero();
  double reach_m = -std::numeric_limits<double>::infinity();
  const auto offer = [&](const Vec3& point_m) {
    const double along_m = math::dot(u, point_m);
    if (along_m > reach_m) furthest = point_m;
    reach_m = std::max(reach_m, along_m);
  };
  for (const physics::ConvexPolyhedron& hull : form.polyhedra)
    std::ranges::for_each(hull.vertices_m(), offer);
  const Vec3 across(u.x(), u.y(), 0);
  const double length = std::max(math::norm(across), 1e-9);  // the axis itself has no direction
  for (const physics::RoundPiece& piece : form.rounds) {
    for (const physics::RoundFeature& ring : piece.features())
      offer(ring.centre_m + (ring.circle_m / length) * across + ring.radius_m * u);
  }
  return furthest;
}

/// A closed surface through rings of `corners` points. It has 2 * rings * corners - 4 triangles.
struct Rings {
  std::uint32_t rings = 0;
  std::uint32_t corners = 0;
};

/// Returns the points, the lowest ring first. The normals of a convex shape are evenly spaced
/// there.
std::vector<Vec3> points_of(const Rings& all, const ShapeSizes& sizes, const BodyForm& form) {
  const double step_rad = 2 * pi / all.corners;
  // Polygons about the axis have the area of the circles.
  const bool is_round = sizes.kind != ShapeKind::hull && sizes.kind != ShapeKind::rounded_box;
  const double widening = is_round ? std::sqrt(step_rad / math::sin(step_rad)) : 1;
  std::vector<Vec3> points_m;
  for (std::uint32_t i = 0; i < all.rings * all.corners; ++i) {
    const math::SinCos turn = math::sincos((i % all.corners + 0.5) * step_rad);
    const math::SinCos up = math::sincos(pi * ((i / all.corners + 0.5) / all.rings - 0.5));
    Vec3 point_m = furthest_m(form, {up.cos * turn.cos, up.cos * turn.sin, up.sin});
    if (sizes.kind == ShapeKind::pin) {  // it isn't convex
      const double height_m = physics::k_bowling_pin_height_m * 0.5 * (1 + up.sin);
      const double radius_m = physics::bowling_pin_radius_m(height_m);
      point_m = {radius_m * turn.cos, radius_m * turn.sin, height_m - form.frame.position_m.z()};
    }
    points_m.emplace_back(widening * point_m.x(), widening * point_m.y(), point_m.z());
  }
  return points_m;
}

std::vector<physics::TriangleCorners> triangles_of(const Rings& all) {
  std::vector<physics::TriangleCorners> triangles;
  const std::uint32_t top = (all.rings - 1) * all.corners;
  for (std::uint32_t i = 0; i < all.corners; ++i) {
    const std::uint32_t next = (i + 1) % all.corners;
    for (std::uint32_t ring = 0; ring < top; ring += all.corners) {
      triangles.push_back({ring + i, ring + next, ring + all.corners + next});
      triangles.push_back({ring + i, ring + all.corners + next, ring + all.corners + i});
    }
    if (i == 0 || next == 0) continue;
    triangles.push_back({0, next, i});
    triangles.push_back({top, top + i, top + next});
  }
  return triangles;
}

class Painter {
 public:
  Painter(const SceneDescription& description, const BuiltScene& built)
      : description_(description), built_(built), models_(description.bodies.size()) {}

  scene::Scene scene() {
    for (const Object& object : built_.objects)
      add(object);
    if (range_.isEmpty()) range_ = {Vec3::Constant(-0.5), Vec3::Constant(0.5)};
    scene_.low_m = range_.min();
    scene_.high_m = range_.max();
    for (scene::Part& part : scene_.parts)
      if (part.shape == scene::Shape::ground) enlarge(part);
    return std::move(scene_);
  }

 private:
  void add(const Object& object) {
    const bool moves = object.kind == ObjectKind::moving;
    const std::uint32_t feature = add_feature(
        scene_, moves ? scene::FeatureKind::body : scene::FeatureKind::fixed, object.name);
    if (object.kind == ObjectKind::mesh) {
      const physics::TriangleMesh& mesh = *built_.scene.meshes[object.first].mesh;
      add_mesh(scene_, mesh, 0);
      if (!physics::is_closed(mesh)) add_back_sides(scene_.parts.back());
      extend(scene_.parts.back(), {});
      return;
    }
    std::vector<scene::Part>& model = models_[object.description];
    if (model.empty()) {
      const auto first = static_cast<std::ptrdiff_t>(scene_.parts.size());
      draw(description_.bodies[object.description]);
      model.assign(scene_.parts.begin() + first, scene_.parts.end());
      scene_.parts.resize(static_cast<std::size_t>(first));
    }
    if (moves) scene_.features.back().twin_of = model.front().feature;
    for (scene::Part part : model) {
      part.feature = feature;
      if (!moves) place(part, object.place);
      extend(part, moves ? object.place : Pose{});
      scene_.parts.push_back(part);
    }
  }

  /// Adds the body's parts in the shape's frame.
  void draw(const BodyDescription& body) {
    std::vector<PartDescription> parts = body.parts;
    if (body.sizes.kind != ShapeKind::compound) parts = {{.sizes = body.sizes}};
    const auto is_mesh = [](const PartDescription& part) {
      return part.sizes.kind != ShapeKind::sphere && part.sizes.kind != ShapeKind::box;
    };
    const auto meshes = static_cast<std::uint32_t>(std::ranges::count_if(parts, is_mesh));
    const std::uint32_t share = k_body_triangles_max / (body.is_static ? 1 : std::max(meshes, 1U));
    for (const PartDescription& part : parts) {
      Pose pose = part.pose;
      if (part.sizes.kind == ShapeKind::sphere) {
        add_part(scene_, scene::Shape::sphere, Vec3::Constant(2 * part.sizes.radius_m));
      } else if (part.sizes.kind == ShapeKind::box) {
        add_part(scene_, scene::Shape::box, part.sizes.size_m);
      } else if (part.sizes.kind == ShapeKind::plane) {
        add_part(scene_, scene::Shape::ground, Vec3::Zero());
      } else {
        const BodyForm form = body_form(part.sizes, {}, 1).value();
        add_solid(part.sizes, form, share, body.is_static);
        pose = composed(pose, form.frame);
      }
      place(scene_.parts.back(), pose);
    }
  }

  /// Adds a solid in its body's frame.
  void add_solid(const ShapeSizes& sizes, const BodyForm& form, std::uint32_t share,
                 bool is_static) {
    const bool is_hull = sizes.kind == ShapeKind::hull;
    if (is_hull) {
      const physics::ConvexPolyhedron& hull = form.polyhedra.front();
      if (is_static || 2 * (hull.edges().size() - hull.faces().size()) <= share)
        return add_polyhedron(scene_, hull);
    }
    if (share < k_share_min) return add_box_like(form);
    // A pin needs more rings.
    const double squeeze = sizes.kind == ShapeKind::pin ? 0.4 : 0.75;
    const auto corners = static_cast<std::uint32_t>(std::sqrt(squeeze * share));
    const Rings rings{.rings = (share + 4) / (2 * corners), .corners = corners};
    const std::vector<Vec3> points_m = points_of(rings, sizes, form);
    if (!is_hull) return add_triangles(scene_, points_m, triangles_of(rings));
    const auto simpler = physics::convex_hull(points_m);
    if (!simpler) return add_box_like(form);
    add_polyhedron(scene_, simpler.value());
  }

  /// Adds a box with the middle, the proportions and the volume of a solid.
  void add_box_like(const BodyForm& form) {
    Eigen::AlignedBox3d around;
    for (int axis = 0; axis < 3; ++axis) {
      around.extend(furthest_m(form, Vec3::Unit(axis)));
      around.extend(furthest_m(form, -Vec3::Unit(axis)));
    }
    const double scale = math::pow(form.volume_m3 / around.volume(), 1.0 / 3);
    add_part(scene_, scene::Shape::box, scale * around.sizes(), around.center());
  }

  /// Repeats a mesh's triangles with the other side outwards, because viewers show only outsides.
  void add_back_sides(scene::Part& part) {
    for (std::uint32_t i = 0; i < part.triangles; ++i) {
      const auto [a, b, c] = scene_.triangles[part.first_triangle + i];
      scene_.triangles.push_back({a, c, b});
    }
    part.triangles *= 2;
  }

  /// Extends the range by a part of a feature at `pose`.
  void extend(scene::Part part, const Pose& pose) {
    place(part, pose);
    const auto add = [&](const Vec3& offset_m) {
      range_.extend(Vec3(part.position_m + math::rotated(part.orientation, offset_m)));
    };
    if (part.shape == scene::Shape::ground) return;
    if (part.shape == scene::Shape::sphere) part.orientation = Quat::Identity();
    for (int corner = 0; corner < 8 && part.shape != scene::Shape::mesh; ++corner)
      add(0.5 * part.size_m.cwiseProduct(
                    Vec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1)));
    for (std::uint32_t i = 0; i < part.triangles; ++i) {
      for (const std::uint32_t vertex : scene_.triangles[part.first_triangle + i])
        add(scene_.vertices[vertex].place_m);
    }
  }

  /// Moves a ground below the middle of all other things, and makes it larger than their range.
  void enlarge(scene::Part& ground) const {
    const Vec3 normal = math::rotated(ground.orientation, Vec3::UnitZ());
    const double above_m = math::dot(normal, Vec3(range_.center() - ground.position_m));
    ground.position_m = range_.center() - above_m * normal;
    const double side_m = 1.5 * math::norm(Vec3(range_.sizes())) + 3 * std::fabs(above_m);
    ground.size_m = {side_m, side_m, 0};
  }

  const SceneDescription& description_;
  const BuiltScene& built_;
  /// By description: the first object's parts, in the shape's frame.
  std::vector<std::vector<scene::Part>> models_;
  scene::Scene scene_;
  Eigen::AlignedBox3d range_;
};

}  // namespace

scene::Scene look_of(const Parameters& parameters) {
  scene::Scene scene = Painter(parameters.scene, *parameters.built).scene();
  for (const Constraint& one : parameters.constraints) {
    if (one.asks != Asks::face) continue;
    for (scene::Part& part : scene.parts) {
      const std::uint32_t body = part.feature;
      const bool is_box = body < parameters.built->moving &&
                          parameters.described(body).sizes.kind == ShapeKind::box;
      if (is_box && std::ranges::count(one.bodies, body) > 0) part.shape = scene::Shape::die;
    }
  }
  return scene;
}

std::vector<motion::Segment> segments_of(const BuiltScene& built,
                                         const physics::Recording& recording) {
  std::vector<RecordedBody> bodies;
  for (std::uint32_t body = 0; body < built.bodies; ++body)
    bodies.push_back({.feature = body,
                      .frame = inverse(built.objects[body].frame),
                      .inertia = built.inertia(body),
                      .reach_m = physics::reach_m(built.scene.bodies[body].shape),
                      .moves = body < built.moving});
  const StaticOwners owners(built);
  return recorded_segments(recording, bodies, [&](std::uint32_t body, std::uint32_t met) {
    return static_cast<std::int32_t>(owners.owner(body, physics::StaticId{met}));
  });
}

}  // namespace sleight::worlds::user_scene
