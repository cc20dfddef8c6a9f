// Static geometry as the bodies of a simulation meet it: features by spheres, pieces by others, and
// after these surfaces.
//
// What a StaticId means is the body's affair, so all is asked for a body.
// Thread safety: none: surfaces keep what they were asked.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "worker/physics/collision/convex_search.h"
#include "worker/physics/collision/surface_search.h"
#include "worker/physics/scene/static_geometry.h"
#include "worker/physics/simulator/bodies.h"

namespace sleight::physics {

/// A spline surface of the scene.
struct MetSurface {
  std::string name;  ///< for people
  SplineSurface surface;
  std::vector<BoxLattice> lattices;  ///< of all bodies' parts, in their order
  std::vector<NearPoints> near;      ///< the same
};

class MetStatics {
 public:
  /// Borrows the bodies; it is that of their scene.
  explicit MetStatics(Bodies& bodies);

  const StaticGeometry& geometry() const { return geometry_; }
  /// Whether there is any.
  bool any() const { return any_; }

  // What a body may meet.
  std::uint32_t count(BodyId body) const;
  void near(BodyId body, const Box& box, std::vector<StaticId>& found) const;
  /// Of some of these, in their order, what it may meet in a box.
  void in(BodyId body, const Box& box, std::span<const StaticId> some,
          std::vector<StaticId>& found) const;
  /// For people.
  const std::string& name(BodyId body, StaticId met) const;
  bool is_surface(BodyId body, StaticId met) const {
    return !bodies_.is_sphere(body) && met >= geometry_.piece_count();
  }
  // REQUIRES, of these: is_surface().
  MetSurface& surface(StaticId met) const { return surfaces_[surface_number(met)]; }
  std::uint32_t surface_number(StaticId met) const { return met - geometry_.piece_count(); }
  const BoxLattice& lattice_on(StaticId met, BodyId body, std::uint32_t part) const {
    return surface(met).lattices[bodies_.constants(body).first_part + part];
  }

  /// How a body bounces off it, at a contact.
  SurfaceLaw law(BodyId body, StaticId met, const Vec3& point_m) const;
  /// Of a part of a body that is no sphere.
  PieceContact contact_of_part(StaticId met, BodyId body, std::uint32_t part, Tick tick) const;
  /// Whether the two touch or overlap at a tick.
  bool touching(BodyId body, StaticId met, Tick tick) const;
  /// The solid that holds a place, by name; empty if none. A body deep inside of one may touch
  /// nothing of it.
  std::string solid_at(const Vec3& place_m) const;

 private:
  Bodies& bodies_;
  StaticGeometry geometry_;
  mutable std::vector<MetSurface> surfaces_;
  bool any_ = false;
};

}  // namespace sleight::physics
