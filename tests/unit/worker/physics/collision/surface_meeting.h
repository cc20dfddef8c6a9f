// A box above a surface, and a reference that examines every lattice point of the box.
#pragma once

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "tests/unit/worker/physics/collision/flyer.h"
#include "tests/unit/worker/physics/collision/surface_tables.h"
#include "worker/physics/collision/surface_search.h"

namespace sleight::physics::testing {

/// All lattice points of a box, in its frame: corners, then edges, then the insides of faces.
inline std::vector<Vec3> points_of(const BoxLattice& lattice, const ConvexView& view) {
  std::vector<Vec3> points_m(view.vertices_m, view.vertices_m + view.vertex_count);
  for (const EdgeLattice& edge : lattice.edges) {
    const Vec3& from_m = view.vertices_m[edge.end[0]];
    for (std::int32_t i = 1; i < edge.steps; ++i)
      points_m.push_back(from_m + (static_cast<double>(i) / edge.steps) *
                                      (view.vertices_m[edge.end[1]] - from_m));
  }
  for (const FaceLattice& face : lattice.faces) {
    const Vec3& from_m = view.vertices_m[face.corner[0]];
    for (std::int32_t i = 1; i < face.along; ++i) {
      for (std::int32_t j = 1; j < face.across; ++j)
        points_m.push_back(
            from_m +
            (static_cast<double>(i) / face.along) * (view.vertices_m[face.corner[1]] - from_m) +
            (static_cast<double>(j) / face.across) * (view.vertices_m[face.corner[3]] - from_m));
    }
  }
  return points_m;
}

struct AllPoints {
  bool collides = false;
  PieceContact contact;  ///< of the colliding point with the least gap
  double least_m = 1;    ///< least gap of all points
};

inline AllPoints look_at_all(SplineSurface& surface, std::span<const Vec3> own_m,
                             const MovingPiece& box) {
  AllPoints all;
  for (const Vec3& point_m : own_m) {
    const Vec3 arm_m = math::product(box.pose.rotation, point_m);
    const Vec3 place_m = arm_m + box.pose.position_m;
    const SurfacePlace below = surface.at(place_m.x(), place_m.y());
    const double gap_m = place_m.z() - below.height_m;
    all.least_m = std::min(all.least_m, gap_m);
    if (gap_m > k_touch_m || (all.collides && gap_m >= all.contact.gap_m)) continue;
    const Vec3 v = box.velocity_mps + math::cross(box.angular_velocity_radps, arm_m);
    const Vec3 normal = math::normalized(Vec3(-below.slope_x, -below.slope_y, 1));
    const double rate_mps = ((v.z() - below.slope_x * v.x()) - below.slope_y * v.y()) * normal.z();
    if (rate_mps >= -k_approach_mps) continue;
    all.collides = true;
    all.contact = {.gap_m = gap_m,
                   .rate_mps = rate_mps,
                   .normal = normal,
                   .point_m = place_m - Vec3(0, 0, 0.5 * gap_m)};
  }
  return all;
}

inline bool same_contact(const PieceContact& a, const PieceContact& b) {
  return a.gap_m == b.gap_m && a.rate_mps == b.rate_mps && a.normal == b.normal &&
         a.point_m == b.point_m;
}

class Meeting {
 public:
  Meeting(const StaticSurface& surface, Flyer& flyer)
      : surface_(surface),
        flyer_(flyer),
        view_(flyer.part().view()),
        lattice_(BoxLattice::of(view_, surface.point_spacing_m).value()),
        own_m_(points_of(lattice_, view_)) {}

  MovingPiece at(Tick tick) const { return flyer_.at(tick, view_); }
  AllPoints all_at(Tick tick) { return look_at_all(surface_, own_m_, at(tick)); }
  PieceContact contact_at(Tick tick) { return contact_of(surface_, lattice_, at(tick)); }
  Examined examine(Tick tick, NearPoints& near, PieceContact& contact) {
    return examine_surface(surface_, lattice_, at(tick), tick, near, contact);
  }
  SplineSurface& surface() { return surface_; }
  const BoxLattice& lattice() const { return lattice_; }
  Flyer& flyer() { return flyer_; }
  std::span<const Vec3> own_m() const { return own_m_; }

  /// Moves the box vertically until its lowest point is `gap_m` above the surface.
  void lower_to(double gap_m) {
    for (int i = 0; i < 3; ++i)
      flyer_.flight.position_m.z() += gap_m - all_at(flyer_.flight.begin).least_m;
  }

 private:
  SplineSurface surface_;
  Flyer& flyer_;
  ConvexView view_;
  BoxLattice lattice_;
  std::vector<Vec3> own_m_;
};

}  // namespace sleight::physics::testing
