#include "worker/physics/simulator/met_statics.h"

#include <algorithm>
#include <iterator>

namespace sleight::physics {
namespace {

/// Whether the box's bottom is below the surface's highest point under the box.
bool reaches_into(const Box& box, SplineSurface& surface) {
  const auto low = [&](std::size_t axis) { return double{box.low_m[axis]}; };
  const auto high = [&](std::size_t axis) { return double{box.high_m[axis]}; };
  return low(2) <= surface.bounds_in(low(0), high(0), low(1), high(1)).top_m;
}

}  // namespace

MetStatics::MetStatics(Bodies& bodies) : bodies_(bodies), geometry_(geometry_of(bodies.scene())) {
  const Scene& scene = bodies.scene();
  for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
    const StaticSurface& surface = scene.surfaces[i];
    surfaces_.push_back(
        {name_of_static("surface", surface.name, i), SplineSurface(surface), {}, {}});
    surfaces_.back().near.resize(bodies.parts().size());
    // Parts that aren't boxes belong to bodies that don't meet the surface (error_of).
    for (const ConvexView& part : bodies.parts())
      surfaces_.back().lattices.push_back(
          BoxLattice::of(part, surface.point_spacing_m).value_or(BoxLattice{}));
  }
  filters_ = scene.filter.any();
  any_ = geometry_->feature_count() > 0 || geometry_->piece_count() > 0 || !surfaces_.empty();
}

// ---- what a body may meet -----------------------------------------------------------------------

std::uint32_t MetStatics::count(BodyId body) const {
  if (bodies_.is_fixed(body)) return 0;
  if (bodies_.is_sphere(body)) return geometry_->feature_count();
  return geometry_->piece_count() + static_cast<std::uint32_t>(surfaces_.size());
}

CollisionGroup MetStatics::group(BodyId body, StaticId met) const {
  if (bodies_.is_sphere(body)) return geometry_->group_of_feature({met});
  return is_surface(body, met) ? bodies_.scene().surfaces[surface_number(met)].group
                               : geometry_->group_of_piece({met});
}

void MetStatics::near(BodyId body, const Box& box, std::vector<StaticId>& found) const {
  const auto before = static_cast<std::ptrdiff_t>(found.size());
  if (bodies_.is_sphere(body)) {
    geometry_->features_near(box, bodies_.constants(body).reach_m, found);
  } else {
    geometry_->pieces_near(box, found);
    for (StaticId met{geometry_->piece_count()}; met < count(body); ++met) {
      if (meets(body, met) && reaches_into(box, surface(met).surface)) found.push_back(met);
    }
  }
  if (!filters_) return;
  found.erase(std::remove_if(found.begin() + before, found.end(),
                             [&](StaticId met) { return !meets(body, met); }),
              found.end());
}

void MetStatics::in(BodyId body, const Box& box, std::span<const StaticId> some,
                    std::vector<StaticId>& found) const {
  if (bodies_.is_sphere(body)) {
    const CentreRange centre(box, bodies_.constants(body).reach_m);
    std::ranges::copy_if(some, std::back_inserter(found),
                         [&](StaticId met) { return geometry_->may_meet({met}, centre); });
    return;
  }
  std::ranges::copy_if(some, std::back_inserter(found), [&](StaticId met) {
    return met < geometry_->piece_count() ? geometry_->piece_overlaps({met}, box)
                                          : reaches_into(box, surface(met).surface);
  });
}

const std::string& MetStatics::name(BodyId body, StaticId met) const {
  if (bodies_.is_sphere(body)) return geometry_->name_of_feature({met});
  return is_surface(body, met) ? surface(met).name : geometry_->name_of_piece({met});
}

std::string MetStatics::solid_at(BodyId body, const Vec3& place_m) const {
  const CollisionGroup own = bodies_.constants(body).group;
  const std::string* solid = geometry_->solid_at(place_m, own);
  if (solid != nullptr) return *solid;
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    if (bodies_.scene().filter.meet(own, bodies_.scene().surfaces[i].group) &&
        place_m.z() < surfaces_[i].surface.at(place_m.x(), place_m.y()).height_m)
      return surfaces_[i].name;
  }
  return "";
}

// ---- contacts -----------------------------------------------------------------------------------

SurfaceLaw MetStatics::law(BodyId body, StaticId met, const Vec3& point_m) const {
  if (is_surface(body, met)) {
    const SurfaceControl law = surface(met).surface.fields_at(point_m.x(), point_m.y());
    return {.restitution = law.restitution, .friction = law.friction};
  }
  const MaterialId material = bodies_.is_sphere(body) ? geometry_->material_of_feature({met})
                                                      : geometry_->material_of_piece({met});
  SurfaceLaw law = bodies_.scene().contacts.between(bodies_.constants(body).material, material);
  law.friction = geometry_->friction_at(met, point_m, law.friction);
  return law;
}

PieceContact MetStatics::contact_of_part(StaticId met, BodyId body, std::uint32_t part,
                                         Tick tick) const {
  const MovingPiece piece = bodies_.part_at(body, part, tick);
  if (is_surface(body, met))
    return contact_of(surface(met).surface, lattice_on(met, body, part), piece);
  return met < geometry_->plane_count() ? contact_of(geometry_->plane({met}), piece)
                                        : contact_of(geometry_->piece({met}), piece);
}

bool MetStatics::touching(BodyId body, StaticId met, Tick tick) const {
  const BodyConstants& constants = bodies_.constants(body);
  if (constants.is_sphere) {
    const SphereFeature& feature = geometry_->feature({met});
    const MovingPoint centre = bodies_.centre_at(body, tick);
    return touches(gap_between(feature, centre, constants.reach_m).gap_m) &&
           is_inside(geometry_->sides(feature), centre.position_m);
  }
  for (std::uint32_t part = 0; part < constants.part_count; ++part) {
    if (touches(contact_of_part(met, body, part, tick).gap_m)) return true;
  }
  return false;
}

}  // namespace sleight::physics
