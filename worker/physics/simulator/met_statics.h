// Static geometry in the form in which a simulation's bodies meet it. Spheres meet features; other
// bodies meet pieces. Surfaces are numbered after the pieces.
//
// All queries take a body, because the meaning of a StaticId depends on it. Thread safety: none,
// because surfaces cache queries.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "worker/physics/collision/convex_search.h"
#include "worker/physics/collision/surface_search.h"
#include "worker/physics/scene/static_geometries.h"
#include "worker/physics/simulator/bodies.h"

namespace sleight::physics {

struct MetSurface {
  std::string name;  ///< for error messages
  SplineSurface surface;
  std::vector<BoxLattice> lattices;  ///< one per part in Bodies::parts()
  std::vector<NearPoints> near;      ///< one per part too
};

class MetStatics {
 public:
  /// Borrows the bodies. Builds the static geometry of their scene unless the scene keeps it.
  explicit MetStatics(Bodies& bodies);

  const StaticGeometry& geometry() const { return *geometry_; }
  bool any() const { return any_; }

  // Candidates for contact. A fixed body has none.
  std::uint32_t count(BodyId body) const;
  /// Whether the body's group meets that of static geometry with an index below count().
  bool meets(BodyId body, StaticId met) const {
    return !filters_ ||
           bodies_.scene().filter.meet(bodies_.constants(body).group, group(body, met));
  }
  /// Appends the static geometry that the body may meet in a box, in ascending order.
  void near(BodyId body, const Box& box, std::vector<StaticId>& found) const;
  /// If the body may meet an element of `some` in a box, appends it. Keeps their order. REQUIRES:
  /// `some` comes from near().
  void in(BodyId body, const Box& box, std::span<const StaticId> some,
          std::vector<StaticId>& found) const;
  const std::string& name(BodyId body, StaticId met) const;
  /// Returns the number of the object that the body meets; see Impact::higher.
  std::uint32_t object(BodyId body, StaticId met) const {
    if (bodies_.is_sphere(body)) return geometry_->object_of_feature({met});
    return is_surface(body, met) ? geometry_->object_count() + surface_number(met)
                                 : geometry_->object_of_piece({met});
  }
  bool is_surface(BodyId body, StaticId met) const {
    return !bodies_.is_sphere(body) && met >= geometry_->piece_count();
  }
  // These functions REQUIRE is_surface().
  MetSurface& surface(StaticId met) const { return surfaces_[surface_number(met)]; }
  std::uint32_t surface_number(StaticId met) const { return met - geometry_->piece_count(); }
  const BoxLattice& lattice_on(StaticId met, BodyId body, std::uint32_t part) const {
    return surface(met).lattices[bodies_.constants(body).first_part + part];
  }

  /// Returns the law of a contact between a body and static geometry at a point.
  SurfaceLaw law(BodyId body, StaticId met, const Vec3& point_m) const;
  PieceContact contact_of_part(StaticId met, BodyId body, std::uint32_t part, Tick tick) const;
  bool touching(BodyId body, StaticId met, Tick tick) const;
  /// Returns the name of the solid that meets the body and contains a point; empty if none. A body
  /// deep inside a solid may touch nothing of the solid's surface; solid_at() finds it.
  std::string solid_at(BodyId body, const Vec3& place_m) const;

 private:
  CollisionGroup group(BodyId body, StaticId met) const;

  Bodies& bodies_;
  std::shared_ptr<const StaticGeometry> geometry_;
  mutable std::vector<MetSurface> surfaces_;
  bool any_ = false;
  bool filters_ = false;  ///< some groups don't meet
};

}  // namespace sleight::physics
