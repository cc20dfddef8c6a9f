// Static geometry as bodies meet it, and what of it lies near a box.
//
// Spheres meet features: faces, edges and vertices, each with its region (sphere_search.h). Bodies
// of convex parts meet convex pieces: half-spaces, polyhedra, triangles (convex_search.h). Each
// plane is one of both, under the same index. Thread safety: const functions may run at once.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "worker/physics/broad_phase/box.h"
#include "worker/physics/simulator/box_tree.h"
#include "worker/physics/simulator/convex_search.h"
#include "worker/physics/simulator/scene.h"
#include "worker/physics/simulator/sphere_search.h"

namespace sleight::physics {

/// What a piece or feature belongs to.
struct StaticOwner {
  std::uint32_t name = 0;  ///< index of its name
  MaterialId material{};
};

class StaticGeometry {
 public:
  /// Borrows the scene's polyhedra.
  explicit StaticGeometry(const Scene& scene);

  std::uint32_t feature_count() const { return static_cast<std::uint32_t>(features_.size()); }
  std::uint32_t piece_count() const {
    return static_cast<std::uint32_t>(plane_count_ + pieces_.size());
  }
  std::uint32_t plane_count() const { return static_cast<std::uint32_t>(plane_count_); }

  const SphereFeature& feature(std::uint32_t index) const { return features_[index]; }
  std::span<const RegionSide> sides(const SphereFeature& feature) const {
    return std::span(sides_).subspan(feature.regions_begin,
                                     feature.regions_end - feature.regions_begin);
  }
  const HalfSpace& plane(std::uint32_t index) const { return planes_[index]; }
  /// REQUIRES: plane_count() <= index < piece_count().
  const MovingPiece& piece(std::uint32_t index) const { return pieces_[index - plane_count_]; }

  MaterialId material_of_feature(std::uint32_t index) const {
    return feature_owners_[index].material;
  }
  MaterialId material_of_piece(std::uint32_t index) const { return piece_owners_[index].material; }
  /// For people.
  const std::string& name_of_feature(std::uint32_t index) const {
    return names_[feature_owners_[index].name];
  }
  const std::string& name_of_piece(std::uint32_t index) const {
    return names_[piece_owners_[index].name];
  }

  /// Appends the indices of what a box overlaps, in ascending order.
  void features_near(const Box& box, std::vector<std::uint32_t>& found) const {
    near(box, feature_tree_, found);
  }
  void pieces_near(const Box& box, std::vector<std::uint32_t>& found) const {
    near(box, piece_tree_, found);
  }

 private:
  void add_features(const ConvexView& view, StaticOwner owner);
  void near(const Box& box, const BoxTree& tree, std::vector<std::uint32_t>& found) const;

  std::size_t plane_count_ = 0;
  std::vector<HalfSpace> planes_;
  std::vector<SphereFeature> features_;
  std::vector<RegionSide> sides_;
  std::vector<StaticOwner> feature_owners_;
  std::vector<Box> feature_boxes_;  ///< from plane_count_ on
  std::vector<ConvexView> views_;
  std::vector<MovingPiece> pieces_;
  std::vector<StaticOwner> piece_owners_;
  std::vector<Box> piece_boxes_;  ///< from plane_count_ on
  BoxTree feature_tree_;
  BoxTree piece_tree_;
  std::vector<std::string> names_;
};

/// Whether some of a box is not outside of a plane.
bool reaches(const HalfSpace& outside, const Box& box);

}  // namespace sleight::physics
