#include "worker/physics/reuse/scene_changes.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <span>

#include "worker/physics/contact/resting.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/scene/same_bits.h"
#include "worker/physics/scene/static_geometries.h"
#include "worker/physics/scene/static_regions.h"

namespace sleight::physics {
namespace {

using physics::same;  // compare numbers bit by bit, and values by their numbers
bool same(const HalfSpace& a, const HalfSpace& b) {
  return same(a.normal, b.normal) && same(a.offset_m, b.offset_m);
}
bool same(const StartState& a, const StartState& b) {
  return same(a.pose.position_m, b.pose.position_m) &&
         same(a.pose.orientation, b.pose.orientation) &&
         same(a.twist.velocity_mps, b.twist.velocity_mps) &&
         same(a.twist.angular_velocity_radps, b.twist.angular_velocity_radps);
}
bool same(const Shape& a, const Shape& b) {
  const auto* first = std::get_if<Sphere>(&a);
  const auto* second = std::get_if<Sphere>(&b);
  if (first != nullptr && second != nullptr) return same(first->radius_m, second->radius_m);
  return first == second && std::get<std::shared_ptr<const Compound>>(a) ==
                                std::get<std::shared_ptr<const Compound>>(b);
}
bool same(const Inertia& a, const Inertia& b) {
  return same(a.mass_kg, b.mass_kg) && same(a.principal_kgm2, b.principal_kgm2) &&
         a.symmetry == b.symmetry;
}
bool same(const SurfaceLaw& a, const SurfaceLaw& b) {
  return same(a.restitution, b.restitution) && same(a.friction, b.friction) &&
         same(a.rolling_friction, b.rolling_friction);
}
bool same(const Control& a, const Control& b) {
  return a.tick == b.tick && a.body == b.body &&
         same(a.velocity_change_mps, b.velocity_change_mps) &&
         same(a.angular_velocity_change_radps, b.angular_velocity_change_radps);
}

bool same(const FrictionMap* a, const FrictionMap* b) {
  return a == b || (a != nullptr && b != nullptr && a->same_as(*b));
}

/// The values may differ: a replay compares them impact by impact.
bool same_noise(const ContactNoise& a, const ContactNoise& b) {
  if (!a.is_on() && !b.is_on()) return true;
  return a.is_on() == b.is_on() && same(a.above_mps, b.above_mps) &&
         same(a.tilt_sd_rad, b.tilt_sd_rad) && same(a.restitution_sd, b.restitution_sd);
}

bool same_laws(const Scene& a, const Scene& b) {
  const bool plain = a.bodies.size() == b.bodies.size() && same(a.gravity_mps2, b.gravity_mps2) &&
                     a.period_m == b.period_m && a.filter == b.filter &&
                     same(a.slow.separation_speed_mps, b.slow.separation_speed_mps) &&
                     same(a.slow.rest_speed_mps, b.slow.rest_speed_mps) &&
                     same(a.slow.rest_time_s, b.slow.rest_time_s) && same_noise(a.noise, b.noise) &&
                     a.contacts.materials() == b.contacts.materials();
  if (!plain) return false;
  for (std::size_t i = 0; i < a.contacts.materials(); ++i) {
    for (std::size_t j = i; j < a.contacts.materials(); ++j) {
      const MaterialId first{static_cast<std::uint8_t>(i)};
      const MaterialId second{static_cast<std::uint8_t>(j)};
      if (!same(a.contacts.between(first, second), b.contacts.between(first, second))) return false;
    }
  }
  return true;
}

/// Returns each surface's control points that may have changed. Returns nothing if any point may
/// have changed.
std::optional<std::vector<std::vector<GridIndex>>> changed_controls(const Scene& before,
                                                                    const Scene& after) {
  std::vector<std::vector<GridIndex>> changed;
  if (before.surfaces.size() != after.surfaces.size()) return std::nullopt;
  for (std::size_t i = 0; i < after.surfaces.size(); ++i) {
    const StaticSurface& was = before.surfaces[i];
    const StaticSurface& is = after.surfaces[i];
    if (!same(was.spacing_m, is.spacing_m) || !same(was.point_spacing_m, is.point_spacing_m) ||
        was.group != is.group)
      return std::nullopt;
    changed.emplace_back();
    if (was.controls == is.controls) continue;
    std::optional<std::vector<GridIndex>> points = is.controls->changed_from(*was.controls);
    if (!points) return std::nullopt;
    changed.back() = *std::move(points);
  }
  return changed;
}

/// Points of a body within this distance of a surface may carry it without touching, if the body
/// touches something elsewhere.
double near_m(const Scene& scene) {
  double reach_m = 0;
  for (const BodyDescription& body : scene.bodies) {
    if (const auto* compound = std::get_if<std::shared_ptr<const Compound>>(&body.shape))
      reach_m = std::max(reach_m, (*compound)->r_outer_m());
  }
  return k_near_corner * reach_m;
}

/// Returns the region in which bodies may depend on a control point. The region covers the patches
/// that depend on the point. The region ends `above_m` above all old and new heights of these
/// patches.
Box place_of(const StaticSurface& was, const StaticSurface& is, GridIndex point, double above_m) {
  double top_m = -std::numeric_limits<double>::infinity();
  for (std::int32_t i = -3; i <= 3; ++i) {
    for (std::int32_t j = -3; j <= 3; ++j) {
      const GridIndex near{point.i + i, point.j + j};
      top_m = std::max({top_m, was.controls->at(near).height_m, is.controls->at(near).height_m});
    }
  }
  const double half_m = 2 * is.spacing_m;
  const Vec3 middle_m(point.i * is.spacing_m, point.j * is.spacing_m, top_m + above_m);
  Box box = joined(box_around(middle_m - Vec3(half_m, half_m, 0)),
                   box_around(middle_m + Vec3(half_m, half_m, 0)));
  box.low_m[2] = -1e6F;  // below all coordinates
  return box;
}

/// Whether most vertices of the meshes moved. Doesn't examine meshes that both scenes share.
bool most_moved(const Scene& a, const Scene& b) {
  std::size_t moved = 0;
  std::size_t all = 0;
  for (std::size_t i = 0; i < std::min(a.meshes.size(), b.meshes.size()); ++i) {
    const auto first = a.meshes[i].mesh->vertices_m();
    const auto second = b.meshes[i].mesh->vertices_m();
    all += std::max(first.size(), second.size());
    if (a.meshes[i].mesh == b.meshes[i].mesh) continue;
    for (std::size_t v = 0; v < std::min(first.size(), second.size()); ++v)
      moved += same(first[v], second[v]) ? 0U : 1U;
  }
  return 2 * moved > all;
}

bool same_feature(const StaticGeometry& a, const StaticGeometry& b, FeatureId index) {
  const SphereFeature& first = a.feature(index);
  const SphereFeature& second = b.feature(index);
  if (a.is_absent(index) && b.is_absent(index)) return true;
  const auto same_side = [](const RegionSide& p, const RegionSide& q) {
    return same(p.space, q.space) && p.strict == q.strict;
  };
  return a.is_absent(index) == b.is_absent(index) && first.kind == second.kind &&
         same(first.point_m, second.point_m) && same(first.direction, second.direction) &&
         std::ranges::equal(a.sides(first), b.sides(second), same_side) &&
         a.material_of_feature(index) == b.material_of_feature(index) &&
         a.group_of_feature(index) == b.group_of_feature(index);
}

bool same_owner(const StaticGeometry& a, const StaticGeometry& b, PieceId index) {
  return a.material_of_piece(index) == b.material_of_piece(index) &&
         a.group_of_piece(index) == b.group_of_piece(index);
}

bool same_piece(const StaticGeometry& a, const StaticGeometry& b, PieceId index) {
  const ConvexView& first = *a.piece(index).view;
  const ConvexView& second = *b.piece(index).view;
  if (!same_owner(a, b, index)) return false;
  if (first.vertex_count != second.vertex_count || first.face_count != second.face_count ||
      first.edge_count != second.edge_count)
    return false;
  for (std::size_t i = 0; i < first.vertex_count; ++i) {
    if (!same(first.vertices_m[i], second.vertices_m[i])) return false;
  }
  for (std::size_t i = 0; i < first.face_count; ++i) {
    const Face& p = first.faces[i];
    const Face& q = second.faces[i];
    if (!same(p.normal, q.normal) || !same(p.offset_m, q.offset_m) ||
        p.first_side != q.first_side || p.side_count != q.side_count)
      return false;
    for (std::size_t k = p.first_side; k < std::size_t{p.first_side} + p.side_count; ++k) {
      if (first.sides[k].vertex != second.sides[k].vertex) return false;
    }
  }
  return true;
}

/// Compares all pieces and features, except those of shared meshes, because some change indirectly:
/// a moved vertex changes the regions in which its neighbours are touched.
class PlaceFinder {
 public:
  PlaceFinder(const StaticGeometry& before, const StaticGeometry& after)
      : before_(before), after_(after) {}

  ChangedPlaces find(std::vector<Box> more) {
    boxes_ = std::move(more);
    if (&before_ != &after_) compare();
    places_.boxes = BoxTree(boxes_);
    places_.has_boxes = !boxes_.empty();
    return std::move(places_);
  }

 private:
  void compare() {
    FeatureId feature{};
    PieceId piece{};
    for (const StaticGeometry::MeshRange& shared : before_.meshes_shared_with(after_)) {
      compare_features(feature, shared.features_begin);
      compare_pieces(piece, shared.pieces_begin);
      feature = shared.features_end;
      piece = shared.pieces_end;
    }
    compare_features(feature, {std::max(before_.feature_count(), after_.feature_count())});
    compare_pieces(piece, {std::max(before_.piece_count(), after_.piece_count())});
  }
  void compare_features(FeatureId begin, FeatureId end) {
    for (FeatureId i = begin; i < end; ++i) {
      const bool in_both = i < before_.feature_count() && i < after_.feature_count();
      if (in_both && is_plane(before_, i) == is_plane(after_, i) &&
          same_feature(before_, after_, i) &&
          same(before_.friction_map({i}), after_.friction_map({i})))
        continue;
      add_feature(before_, i);
      add_feature(after_, i);
    }
  }
  void compare_pieces(PieceId begin, PieceId end) {
    for (PieceId i = begin; i < end; ++i) {
      const bool in_both = i < before_.piece_count() && i < after_.piece_count();
      if (in_both && is_plane(before_, i) && is_plane(after_, i)) {
        if (same(before_.plane(i), after_.plane(i)) && same_owner(before_, after_, i) &&
            same(before_.friction_map({i}), after_.friction_map({i})))
          continue;
      } else if (in_both && !is_plane(before_, i) && !is_plane(after_, i) &&
                 same_piece(before_, after_, i)) {
        continue;
      }
      add_piece(before_, i);
      add_piece(after_, i);
    }
  }
  static bool is_plane(const StaticGeometry& statics, std::uint32_t index) {
    return index < statics.plane_count();
  }
  void add_feature(const StaticGeometry& statics, FeatureId index) {
    if (index >= statics.feature_count()) return;
    if (is_plane(statics, index)) {
      places_.outside.push_back(statics.plane({index}));
    } else {
      boxes_.push_back(statics.feature_box(index));
    }
  }
  void add_piece(const StaticGeometry& statics, PieceId index) {
    if (index >= statics.piece_count()) return;
    if (is_plane(statics, index)) {
      places_.outside.push_back(statics.plane(index));
      return;
    }
    const ConvexView& view = *statics.piece(index).view;
    boxes_.push_back(box_around(std::span(view.vertices_m, view.vertex_count)));
  }

  const StaticGeometry& before_;
  const StaticGeometry& after_;
  ChangedPlaces places_;
  std::vector<Box> boxes_;
};

}  // namespace

bool ChangedPlaces::meet(const Box& body) const {
  const auto reached = [&](const HalfSpace& plane) { return reaches(plane, body); };
  if (std::ranges::any_of(outside, reached)) return true;
  bool met = false;
  boxes.for_each_overlap(body, [&](std::uint32_t) { met = true; });
  return met;
}

std::vector<std::uint32_t> controls_in_order(const Scene& scene) {
  std::vector<std::uint32_t> order(scene.controls.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return scene.controls[i].tick; });
  return order;
}

SceneChanges changes_between(const Scene& before, const Scene& after,
                             const StaticGeometry& statics) {
  SceneChanges changes;
  changes.laws = !same_laws(before, after);
  if (changes.laws) return changes;
  bool all_differ = true;
  for (std::size_t i = 0; i < after.bodies.size(); ++i) {
    const BodyDescription& was = before.bodies[i];
    const BodyDescription& is = after.bodies[i];
    const bool same_shape = same(was.shape, is.shape);
    const bool both_fixed = was.fixed && is.fixed;
    const bool differs = !same_shape || !same(was.inertia, is.inertia) || was.rests != is.rests ||
                         was.fixed != is.fixed || was.group != is.group ||
                         was.material != is.material || was.start_tick != is.start_tick ||
                         !same(was.start, is.start);
    all_differ = all_differ && (differs || both_fixed);
    changes.bodies.push_back(differs ? 1 : 0);
    if (differs) changes.first = std::min({changes.first, was.start_tick, is.start_tick});
  }
  // If most of the scene has changed, almost nothing can be replayed. So skip the comparison of
  // features, which takes as long as some simulations.
  if (all_differ || most_moved(before, after)) {
    changes.laws = true;
    return changes;
  }
  const auto controls = changed_controls(before, after);
  changes.laws = !controls.has_value();
  if (changes.laws) return changes;
  std::vector<Box> over_surfaces;
  const double above_m = std::max(near_m(before), near_m(after));
  for (std::size_t i = 0; i < controls->size(); ++i) {
    for (const GridIndex point : (*controls)[i])
      over_surfaces.push_back(place_of(before.surfaces[i], after.surfaces[i], point, above_m));
  }
  if (!same_geometry(before, after) || !over_surfaces.empty()) {
    const std::shared_ptr<const StaticGeometry> kept = geometry_of(before);
    const StaticGeometry& old = *kept;
    // Laws count as changed if spheres can stay on static geometry in only one of the scenes. Laws
    // also count as changed if the number of pieces differs, because surfaces are numbered after
    // the pieces.
    changes.laws = (old.feature_count() > 0) != (statics.feature_count() > 0) ||
                   (!after.surfaces.empty() && old.piece_count() != statics.piece_count());
    if (changes.laws) return changes;
    changes.places = PlaceFinder(old, statics).find(std::move(over_surfaces));
  }
  const std::vector<std::uint32_t> old_order = controls_in_order(before);
  const std::vector<std::uint32_t> order = controls_in_order(after);
  std::size_t& common = changes.same_controls;
  while (common < std::min(old_order.size(), order.size()) &&
         same(before.controls[old_order[common]], after.controls[order[common]])) {
    ++common;
  }
  if (common < old_order.size())
    changes.first = std::min(changes.first, before.controls[old_order[common]].tick);
  if (common < order.size())
    changes.first = std::min(changes.first, after.controls[order[common]].tick);
  return changes;
}

}  // namespace sleight::physics
