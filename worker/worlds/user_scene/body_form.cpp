#include "worker/worlds/user_scene/body_form.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <utility>

#include "common/base/check.h"
#include "common/math/elementary.h"
#include "worker/physics/shape/mass_properties.h"
#include "worker/physics/shape/round_solids.h"

namespace sleight::worlds::user_scene {
namespace {

using physics::InertiaSymmetry;
using physics::Mat3;
using FormResult = base::Result<BodyForm, FormError>;

FormError wrong(std::string key, const physics::ShapeError& error) {
  return {std::move(key), physics::describe(error)};
}

FormResult sphere_form(double radius_m, double density_kgpm3) {
  auto ball = physics::RoundPiece::make({.rings = {}, .balls = {{.radius_m = radius_m}}});
  if (!ball) return wrong("radius_mm", ball.error());
  BodyForm form;
  form.volume_m3 = 4 * std::numbers::pi / 3 * radius_m * radius_m * radius_m;
  form.rounds.push_back(std::move(ball).value());
  form.inertia = physics::solid_ball_inertia(density_kgpm3 * form.volume_m3, radius_m);
  return form;
}

/// Puts a polyhedron into its body's frame.
FormResult polyhedron_form(const physics::ConvexPolyhedron& hull, double density_kgpm3,
                           InertiaSymmetry symmetry, const std::string& key) {
  auto made = physics::in_body_frame({&hull, 1}, density_kgpm3, symmetry);
  if (!made) return wrong(key, made.error());
  BodyForm form;
  form.polyhedra = made.value().parts;
  form.inertia = made.value().inertia;
  form.frame = made.value().frame;
  form.volume_m3 = form.inertia.mass_kg / density_kgpm3;
  return form;
}

FormResult box_form(const Vec3& sides_m, double density_kgpm3) {
  auto box = physics::box(sides_m);
  if (!box) return wrong("size_mm", box.error());
  const bool xy = sides_m.x() == sides_m.y();
  const bool yz = sides_m.y() == sides_m.z();
  const bool zx = sides_m.z() == sides_m.x();
  return polyhedron_form(box.value(), density_kgpm3,
                         xy && yz         ? InertiaSymmetry::spherical
                         : xy || yz || zx ? InertiaSymmetry::axial
                                          : InertiaSymmetry::general,
                         "size_mm");
}

/// A solid of revolution, or one that is symmetric like it. `lowest_m`: height of its lowest point
/// in the shape's frame.
FormResult round_form(physics::RoundResult made, const std::string& key, double lowest_m) {
  if (!made) return wrong(key, made.error());
  physics::RoundSolid solid = std::move(made).value();
  BodyForm form;
  form.rounds = std::move(solid.parts);
  form.inertia = solid.inertia;
  form.frame.position_m.z() = lowest_m + solid.foot_m;
  form.volume_m3 = solid.volume_m3;
  return form;
}

// ---- compounds ----------------------------------------------------------------------------------

/// If all pieces are round about the z axis, declares the inertia axial and returns true. The free
/// rotation is then a closed function of time.
bool make_axial(BodyForm& form) {
  if (!form.polyhedra.empty()) return false;
  physics::Compound compound;
  compound.round_parts = form.rounds;
  if (!physics::axis_of_revolution(compound)) return false;
  Vec3& moments = form.inertia.principal_kgm2;
  moments.x() = moments.y() = 0.5 * (moments.x() + moments.y());
  form.inertia.symmetry = InertiaSymmetry::axial;
  return true;
}

/// Fails if an edge is too sharp for the distance from the new origin.
base::Result<physics::RoundPiece, physics::ShapeError> moved(const physics::RoundPiece& piece,
                                                             const Pose& pose) {
  const auto place_m = [&](const Vec3& p) {
    return Vec3(pose.position_m + math::rotated(pose.orientation, p));
  };
  physics::RoundDescription description;
  description.origin_m = place_m(piece.origin_m());
  description.axis = math::normalized(math::rotated(pose.orientation, piece.axis()));
  const bool on_axis = piece.of_revolution();
  for (const physics::RoundFeature& feature : piece.features()) {
    if (on_axis || feature.circle_m > 0) {
      description.rings.push_back({.height_m = feature.height_m,
                                   .circle_m = feature.circle_m,
                                   .radius_m = feature.radius_m});
    } else {
      description.balls.push_back(
          {.centre_m = place_m(feature.centre_m), .radius_m = feature.radius_m});
    }
  }
  return physics::RoundPiece::make(description);
}

struct PlacedPart {
  BodyForm form;
  Pose pose;  ///< the part's body frame in the compound's frame
};

/// Puts the parts' pieces into the compound's body frame, form.frame.
std::optional<FormError> gather(std::span<const PlacedPart> parts, BodyForm& form) {
  form.polyhedra.clear();
  form.rounds.clear();
  const Quat back = math::inverse(form.frame.orientation);
  for (const PlacedPart& part : parts) {
    const Pose pose{.position_m = math::rotated(back, part.pose.position_m - form.frame.position_m),
                    .orientation = math::composed(back, part.pose.orientation)};
    for (const physics::ConvexPolyhedron& piece : part.form.polyhedra)
      form.polyhedra.push_back(
          physics::moved(piece, math::matrix_of(pose.orientation), pose.position_m));
    for (const physics::RoundPiece& piece : part.form.rounds) {
      auto made = moved(piece, pose);
      if (!made) return wrong("part", made.error());
      form.rounds.push_back(std::move(made).value());
    }
  }
  return std::nullopt;
}

FormResult compound_form(std::span<const PartDescription> parts, double density_kgpm3) {
  CHECK(!parts.empty());
  std::vector<PlacedPart> placed;
  double mass_kg = 0;
  Vec3 moment_kgm = Vec3::Zero();
  for (const PartDescription& part : parts) {
    auto made = body_form(part.sizes, {}, part.density_kgpm3.value_or(density_kgpm3));
    if (!made) return made.error();
    placed.push_back({made.value(), composed(part.pose, made.value().frame)});
    mass_kg += made.value().inertia.mass_kg;
    moment_kgm += made.value().inertia.mass_kg * placed.back().pose.position_m;
  }

  // Add the parts' inertia about the common centre (parallel axis theorem).
  BodyForm form;
  form.frame.position_m = moment_kgm / mass_kg;
  Mat3 inertia_kgm2 = Mat3::Zero();
  for (const PlacedPart& part : placed) {
    const physics::Inertia& own = part.form.inertia;
    const Mat3 turn = math::matrix_of(part.pose.orientation);
    const Vec3 d = part.pose.position_m - form.frame.position_m;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        double sum = -own.mass_kg * d[i] * d[j];
        if (i == j) sum += own.mass_kg * math::dot(d, d);
        for (int k = 0; k < 3; ++k)
          sum += turn(i, k) * own.principal_kgm2[k] * turn(j, k);
        inertia_kgm2(i, j) += sum;
      }
    }
    form.volume_m3 += part.form.volume_m3;
  }
  form.inertia = {.mass_kg = mass_kg,
                  .principal_kgm2 = inertia_kgm2.diagonal(),
                  .symmetry = InertiaSymmetry::general};

  if (auto error = gather(placed, form)) return *error;
  if (make_axial(form)) return form;
  const physics::PrincipalAxes axes = physics::principal_axes(inertia_kgm2);
  form.inertia.principal_kgm2 = axes.moments;
  form.frame.orientation = math::normalized(Quat(axes.axes));
  if (auto error = gather(placed, form)) return *error;
  return form;
}

// ---- channels -----------------------------------------------------------------------------------

struct Channel {
  std::vector<Vec3> points_m;
  std::vector<physics::TriangleCorners> triangles;
};

/// Returns the mesh of a helix or ramp: 2 n m triangles for n steps and m strips.
Channel channel_of(const ShapeSizes& sizes) {
  CHECK(sizes.steps >= 1 && sizes.strips >= 2);
  Channel channel;
  for (std::uint32_t step = 0; step <= sizes.steps; ++step) {
    const double share = 1.0 * step / sizes.steps;
    const double angle_rad = 2 * std::numbers::pi * sizes.turns * share;
    for (std::uint32_t strip = 0; strip <= sizes.strips; ++strip) {
      const double across_rad = std::numbers::pi * (1.0 * strip / sizes.strips - 1);
      const double sideways_m = sizes.radius_m * math::cos(across_rad);
      const double z_m = sizes.radius_m * math::sin(across_rad) - sizes.drop_m * share;
      if (sizes.kind == ShapeKind::ramp) {
        channel.points_m.emplace_back(sizes.length_m * share, -sideways_m, z_m);
      } else {
        const double r_m = sizes.path_radius_m + sideways_m;
        channel.points_m.emplace_back(r_m * math::cos(angle_rad), r_m * math::sin(angle_rad), z_m);
      }
    }
  }
  const auto point = [&](std::uint32_t step, std::uint32_t strip) {
    return step * (sizes.strips + 1) + strip;
  };
  for (std::uint32_t step = 0; step < sizes.steps; ++step) {
    for (std::uint32_t strip = 0; strip < sizes.strips; ++strip) {
      channel.triangles.push_back(
          {point(step, strip), point(step + 1, strip), point(step + 1, strip + 1)});
      channel.triangles.push_back(
          {point(step, strip), point(step + 1, strip + 1), point(step, strip + 1)});
    }
  }
  return channel;
}

}  // namespace

Pose composed(const Pose& outer, const Pose& inner) {
  return {.position_m = outer.position_m + math::rotated(outer.orientation, inner.position_m),
          .orientation = math::normalized(math::composed(outer.orientation, inner.orientation))};
}

Pose inverse(const Pose& pose) {
  const Quat back = math::inverse(pose.orientation);
  return {.position_m = -math::rotated(back, pose.position_m), .orientation = back};
}

base::Result<physics::TriangleMesh, FormError> mesh_form(const ShapeSizes& sizes,
                                                         const Pose& pose) {
  Channel drawn{.points_m = sizes.points_m, .triangles = sizes.triangles};
  if (sizes.kind != ShapeKind::mesh) drawn = channel_of(sizes);
  for (Vec3& point_m : drawn.points_m)
    point_m = pose.position_m + math::rotated(pose.orientation, point_m);
  auto mesh = physics::TriangleMesh::make(
      drawn.points_m, drawn.triangles,
      sizes.closed ? physics::MeshClosure::closed : physics::MeshClosure::may_be_open);
  if (!mesh) return FormError{"triangles", physics::describe(mesh.error())};
  return std::move(mesh).value();
}

physics::Inertia with_mass(physics::Inertia inertia, double mass_kg) {
  inertia.principal_kgm2 *= mass_kg / inertia.mass_kg;
  inertia.mass_kg = mass_kg;
  return inertia;
}

physics::Shape BodyForm::shape(const ShapeSizes& sizes) const {
  if (sizes.kind == ShapeKind::sphere) return physics::Sphere{sizes.radius_m};
  auto compound = std::make_shared<physics::Compound>();
  compound->parts = polyhedra;
  compound->round_parts = rounds;
  return std::shared_ptr<const physics::Compound>(std::move(compound));
}

FormResult body_form(const ShapeSizes& sizes, std::span<const PartDescription> parts,
                     double density_kgpm3) {
  switch (sizes.kind) {
    case ShapeKind::sphere:
      return sphere_form(sizes.radius_m, density_kgpm3);
    case ShapeKind::box:
      return box_form(sizes.size_m, density_kgpm3);
    case ShapeKind::capsule:
      return round_form(
          physics::capsule(sizes.radius_m, sizes.length_m - 2 * sizes.radius_m, density_kgpm3),
          "length_mm", -0.5 * sizes.length_m);
    case ShapeKind::cylinder:
      return round_form(
          physics::cylinder(sizes.radius_m, sizes.length_m, sizes.edge_m, density_kgpm3), "edge_mm",
          -0.5 * sizes.length_m);
    case ShapeKind::cone:
      return round_form(physics::cone(sizes.radius_m, sizes.length_m, sizes.edge_m, density_kgpm3),
                        "edge_mm", -0.5 * sizes.length_m);
    case ShapeKind::rounded_box:
      return round_form(physics::rounded_box(sizes.size_m, sizes.edge_m, density_kgpm3), "edge_mm",
                        -0.5 * sizes.size_m.z());
    case ShapeKind::pin: {
      // Scale a pin of 1 kg, because its maker takes a mass.
      FormResult pin = round_form(physics::bowling_pin(1), "shape", 0);
      if (!pin) return pin;
      BodyForm form = std::move(pin).value();
      form.inertia = with_mass(form.inertia, density_kgpm3 * form.volume_m3);
      return form;
    }
    case ShapeKind::hull: {
      auto hull = physics::convex_hull(sizes.points_m);
      if (!hull) return wrong("points_mm", hull.error());
      return polyhedron_form(hull.value(), density_kgpm3, InertiaSymmetry::general, "points_mm");
    }
    case ShapeKind::compound:
      return compound_form(parts, density_kgpm3);
    case ShapeKind::plane:
    case ShapeKind::mesh:
    case ShapeKind::helix:
    case ShapeKind::ramp:
      break;
  }
  base::check_failed("the shape is a solid", "");
}

}  // namespace sleight::worlds::user_scene
