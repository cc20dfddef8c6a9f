// Static geometry in the form in which bodies meet it. Queries find the parts near a box.
//
// Idea. Spheres meet features: faces, edges and vertices, each with its region (sphere_search.h).
// Bodies made of convex parts meet convex pieces: half-spaces, polyhedra and triangles
// (convex_search.h). Each plane is both a feature and a piece, with the same index.
//
// A sphere touches the feature that contains the point closest to the sphere's centre. So a face's
// region is the prism above the face. An edge's region is between the edge's ends and outside the
// prisms of its faces. A vertex's region is beyond the ends of all its edges. Spheres meet a closed
// mesh from outside. A closed mesh's concave and flat edges are left out, because a sphere touches
// the adjacent faces first. Spheres meet an open mesh, a sheet, from both sides: each triangle
// counts as two faces, back to back. If a sheet's edge is concave from one side, it is met from the
// other side; so only flat edges are left out. A sheet's edge has one region for both sides: the
// wedge between the adjacent prisms on the convex side.
//
// Invariants
//   1. Planes come first, then features of convexes, then features of meshes. Each mesh's features
//      are its faces (a sheet has each face twice), then its edges, then its vertices, in the
//      mesh's order. Features that can't be met stay in the list with an empty region, so indices
//      stay the same when vertices move.
//   2. Every point outside the solids is in the region of the feature closest to the point.
//      Adjacent regions have bitwise equal borders. Regions of faces and vertices extend over them
//      by a few rounding errors, so that no sphere slips through between two regions. Where two
//      regions overlap, their gaps and normals agree to rounding.
//   3. Features exist only if some moving body is a sphere, and convex pieces only if some moving
//      body is not a sphere.
// Building takes about 35 ns per feature, and 130 ns per triangle if triangles are pieces. A
// refresh takes about 20 ns per feature around the moved vertices. Thread safety: const functions
// may run concurrently.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "worker/physics/broad_phase/box.h"
#include "worker/physics/collision/convex_search.h"
#include "worker/physics/collision/sphere_search.h"
#include "worker/physics/event/ids.h"
#include "worker/physics/scene/box_tree.h"
#include "worker/physics/scene/scene.h"
#include "worker/physics/shape/small_pieces.h"

namespace sleight::physics {

/// Returns whether the box reaches below the plane, into the solid.
bool reaches(const HalfSpace& outside, const Box& box);

/// Returns a name for error messages, such as "plane 'floor'". If `given` is empty, uses the index:
/// "plane 0".
std::string name_of_static(std::string_view kind, const std::string& given, std::size_t index);

/// The properties of a scene's moving bodies on which StaticGeometry depends.
struct MovingKinds {
  bool spheres = false;
  bool others = false;
  /// A bound of the spheres' radii. The bound is a power of two, so that scenes with slightly
  /// different radii have the same geometry.
  double radius_m_max = 0;
  friend bool operator==(const MovingKinds&, const MovingKinds&) = default;
};
MovingKinds moving_kinds(const Scene& scene);

struct StaticOwner {
  std::uint32_t name = 0;  ///< index into names_
  MaterialId material{};
  CollisionGroup group{};
};

/// The positions that a sphere's centre can have while the sphere stays in a box. Queries extend
/// this range by k_touch_m on all sides to cover rounding.
struct CentreRange {
  CentreRange(const Box& box, double radius_m);
  Vec3 middle_m;
  Vec3 half_m;
  double reach_m;  ///< radius plus the touch distance
  double away_m;   ///< distance from the middle that covers everything within reach of a corner

  /// Half the range's extent along a direction.
  double spread_m(const Vec3& direction) const {
    return (std::fabs(direction.x()) * half_m.x() + std::fabs(direction.y()) * half_m.y()) +
           std::fabs(direction.z()) * half_m.z();
  }
};

class StaticGeometry {
 public:
  /// Shares the scene's polyhedra and meshes. REQUIRES: error_of(scene) has none.
  explicit StaticGeometry(const Scene& scene);
  /// Updates a mesh (by its index in the scene) after its last move of vertices. After refresh(),
  /// this object equals newly built geometry. REQUIRES: only spheres meet the geometry.
  void refresh(std::size_t mesh);
  // Pieces point into arrays of this object; moving the object keeps the arrays in place.
  StaticGeometry(StaticGeometry&&) noexcept = default;
  StaticGeometry& operator=(StaticGeometry&&) noexcept = default;
  StaticGeometry(const StaticGeometry&) = delete;
  StaticGeometry& operator=(const StaticGeometry&) = delete;
  ~StaticGeometry() = default;

  std::uint32_t feature_count() const { return static_cast<std::uint32_t>(features_.size()); }
  std::uint32_t piece_count() const {
    return static_cast<std::uint32_t>(plane_count_ + pieces_.size());
  }
  std::uint32_t plane_count() const { return static_cast<std::uint32_t>(plane_count_); }

  const SphereFeature& feature(FeatureId index) const { return features_[index]; }
  std::span<const RegionSide> sides(const SphereFeature& feature) const {
    return std::span(sides_).subspan(feature.regions_begin,
                                     feature.regions_end - feature.regions_begin);
  }
  /// Whether no sphere can meet the feature at the current positions of its mesh's vertices.
  bool is_absent(FeatureId index) const { return is_absent(features_[index]); }
  static bool is_absent(const SphereFeature& feature) {
    return feature.regions_end == k_nothing + 1;
  }
  /// Bounding box of a feature. The box also contains the feature after vertices have moved within
  /// the slack. REQUIRES: the feature is not a plane.
  const Box& feature_box(FeatureId index) const { return feature_boxes_[index - plane_count_]; }
  /// Counts how often refresh() rebuilt feature boxes because a vertex had left its slack.
  std::uint64_t boxes_made() const { return boxes_made_; }
  /// Features that the last refresh rewrote; some may be listed twice.
  std::span<const FeatureId> refreshed() const { return refreshed_; }
  /// If one vertex moves and border_m stays the same, only these features and edges of the mesh can
  /// change. If border_m changes, all can.
  struct About {
    std::vector<FeatureId> features;  ///< features that depend on the vertex
    /// Faces that don't depend on the vertex but are adjacent to faces that depend on it. Such a
    /// face's region changes only if the edge in between becomes flat or stops being flat.
    std::vector<FeatureId> beside;
    std::vector<std::uint32_t> edges;  ///< mesh edges that can change
  };
  About about(std::size_t mesh, std::uint32_t vertex) const;
  /// Returns how far a mesh's regions extend over their borders: the rounding error at the mesh's
  /// greatest coordinate.
  double border_m(std::size_t mesh) const { return meshes_[mesh].margins.border_m; }
  const HalfSpace& plane(PieceId index) const { return planes_[index]; }
  /// REQUIRES: plane_count() <= index < piece_count().
  const MovingPiece& piece(PieceId index) const { return pieces_[index - plane_count_]; }

  /// Returns a plane's friction map, or null. Planes have the same index as feature and as piece.
  const FrictionMap* friction_map(StaticId index) const {
    return index < friction_maps_.size() ? friction_maps_[index].get() : nullptr;
  }
  /// Returns the friction where a body touches a feature or piece. `otherwise`: the contact table's
  /// value.
  double friction_at(StaticId index, const Vec3& point_m, double otherwise) const {
    const FrictionMap* map = friction_map(index);
    return map == nullptr ? otherwise : map->friction_at(point_m).value_or(otherwise);
  }

  MaterialId material_of_feature(FeatureId index) const { return feature_owners_[index].material; }
  MaterialId material_of_piece(PieceId index) const { return piece_owners_[index].material; }
  CollisionGroup group_of_feature(FeatureId index) const { return feature_owners_[index].group; }
  CollisionGroup group_of_piece(PieceId index) const { return piece_owners_[index].group; }
  /// Number of the object: planes, convexes and meshes are numbered in this order.
  std::uint32_t object_of_feature(FeatureId index) const { return feature_owners_[index].name; }
  std::uint32_t object_of_piece(PieceId index) const { return piece_owners_[index].name; }
  std::uint32_t object_count() const { return static_cast<std::uint32_t>(names_.size()); }
  const std::string& name_of_feature(FeatureId index) const {
    return names_[feature_owners_[index].name];
  }
  const std::string& name_of_piece(PieceId index) const {
    return names_[piece_owners_[index].name];
  }

  /// Appends, in ascending order, the features that a sphere may meet while it stays in a box.
  void features_near(const Box& box, double radius_m, std::vector<StaticId>& found) const;
  /// Appends the pieces that overlap a box, in ascending order.
  void pieces_near(const Box& box, std::vector<StaticId>& found) const;

  /// Whether a sphere may meet a feature: whether its centre can enter the feature's region and
  /// come close enough. Inline for speed, since the simulator calls may_meet for each feature near
  /// each new box.
  bool may_meet(FeatureId index, const CentreRange& centre) const {
    const SphereFeature& one = features_[index];
    const Vec3 from = centre.middle_m - one.point_m;
    const double along_m = math::dot(one.direction, from);  // 0 for a vertex
    if (one.kind == FeatureKind::face) {
      if (along_m - centre.spread_m(one.direction) > centre.reach_m) return false;
    } else if (math::dot(from, from) - along_m * along_m > centre.away_m * centre.away_m) {
      return false;
    }
    for (std::uint32_t i = one.regions_begin; i < one.regions_end; ++i) {
      const HalfSpace& side = sides_[i].space;
      if (math::dot(side.normal, centre.middle_m) + centre.spread_m(side.normal) < side.offset_m)
        return false;
    }
    return true;
  }
  bool piece_overlaps(PieceId index, const Box& box) const {
    return index < plane_count_ ? reaches(planes_[index], box)
                                : overlap(piece_boxes_[index - plane_count_], box);
  }

  /// Features and pieces of a mesh, as half-open ranges of indices.
  struct MeshRange {
    FeatureId features_begin{}, features_end{};
    PieceId pieces_begin{}, pieces_end{};
    friend bool operator==(const MeshRange&, const MeshRange&) = default;
  };
  /// Returns the meshes that equal those of `other`: they are the same object, and have the same
  /// indices, regions, material and group. In ascending order.
  std::vector<MeshRange> meshes_shared_with(const StaticGeometry& other) const;

  /// Returns the name of the solid that contains a point: a plane's lower side, a polyhedron or a
  /// closed mesh. Returns null if no solid that meets `group` contains the point. So a body is
  /// detected that starts wholly inside a solid and touches no feature of its surface. The answer
  /// is exact except for points within a rounding error of a surface. Examines the triangles above
  /// the point. REQUIRES: the scene has a moving body.
  const std::string* solid_at(const Vec3& point_m, CollisionGroup group = {}) const;

 private:
  /// Index of the first side. No point satisfies this side, so a region that has only this side is
  /// empty.
  static constexpr std::uint32_t k_nothing = 0;

  struct Sizes;
  /// How far the regions of faces and vertices extend over their borders.
  struct Margins {
    double border_m = 0;
    double flat_m = 0;  ///< over edges that count as flat but may not be quite flat
    friend bool operator==(const Margins&, const Margins&) = default;
  };
  void reserve(const Sizes& sizes);
  Margins margins_of(std::span<const Vec3> vertices_m) const;
  void add_plane(const StaticPlane& plane);
  void add_convex(const StaticConvex& convex);
  void add_mesh(const StaticMesh& mesh);
  void add_features(const ConvexView& view, StaticOwner owner);
  struct MeshPlace {
    std::shared_ptr<const TriangleMesh> mesh;
    StaticOwner owner;
    std::size_t solid = 0;  ///< index of the solid, if the mesh is closed
    bool closed = false;
    double slack_m = 0;
    Margins margins;
    MeshRange range{};
    std::vector<Vec3> homes_m{};  ///< vertices when boxes were last built; empty without slack
    std::uint32_t first_edge = 0, first_vertex = 0;
    std::uint32_t face_sides = 0, edge_sides = 0;
    std::vector<std::uint32_t> vertex_sides{};  ///< the sides of vertex v are [v] to [v + 1]
    /// By triangle: how far its region extends over each of its three borders.
    std::vector<std::array<double, 3>> face_margins_m{};
    /// By edge: the indices of its two sides. Each is in the region of one end vertex.
    std::vector<std::array<std::uint32_t, 2>> end_sides{};
    bool keeps_side = false;  ///< no move within the slack turns the mesh inside out
  };
  void add_features(MeshPlace& place);
  void lay_out(MeshPlace& place);
  void write_margins(MeshPlace& place, std::uint32_t triangle) const;
  // These functions rewrite the given faces, edges or vertices (indices in the mesh).
  void write_faces(const MeshPlace& place, std::span<const std::uint32_t> triangles);
  void write_edges(const MeshPlace& place, std::span<const std::uint32_t> numbers);
  void write_vertices(const MeshPlace& place, std::span<const std::uint32_t> vertices);
  void write_boxes(MeshPlace& place);
  void write_all(MeshPlace& place);
  void write_moved(MeshPlace& place);
  void plant_feature_tree();
  void add_piece(const ConvexView& view, const Box& box, StaticOwner owner);
  void add_feature(SphereFeature feature, std::uint32_t first_side, const Box& box,
                   StaticOwner owner);
  std::uint32_t side_count() const { return static_cast<std::uint32_t>(sides_.size()); }

  struct Solid {
    StaticOwner owner;
    std::shared_ptr<const ConvexPolyhedron> polyhedron;  ///< set unless `mesh` is
    std::shared_ptr<const TriangleMesh> mesh;
    bool hollow = false;    ///< the mesh's normals point inwards, so everything outside is solid
    std::size_t place = 0;  ///< of the mesh in meshes_
  };

  bool is_solid_at(const Solid& solid, const Vec3& point_m) const;

  CollisionFilter filter_;
  MovingKinds moving_;
  std::size_t plane_count_ = 0;
  std::vector<HalfSpace> planes_;
  std::vector<std::shared_ptr<const FrictionMap>> friction_maps_;  ///< empty if no plane has a map
  std::vector<SphereFeature> features_;
  std::vector<RegionSide> sides_;
  std::vector<StaticOwner> feature_owners_;
  std::vector<Box> feature_boxes_;        ///< starts at feature plane_count_
  std::vector<TrianglePiece> triangles_;  ///< never reallocates beyond the reserved size
  std::vector<ConvexView> views_;         ///< never reallocates either
  std::vector<MovingPiece> pieces_;
  std::vector<StaticOwner> piece_owners_;
  std::vector<Box> piece_boxes_;  ///< starts at piece plane_count_
  std::vector<MeshPlace> meshes_;
  BoxTree feature_tree_;
  std::vector<FeatureId> in_feature_tree_;  ///< by index in feature_tree_: the feature
  BoxTree piece_tree_;
  std::vector<std::string> names_;
  std::vector<Solid> solids_;
  std::uint64_t boxes_made_ = 0;
  std::vector<FeatureId> refreshed_;
  std::vector<std::uint32_t> beside_;  ///< triangles, while refreshing
  std::vector<std::uint32_t> every_;   ///< 0, 1, 2, ... for all faces, edges or vertices of a mesh
  // Scratch memory for building.
  std::vector<Box> corner_boxes_;
  std::vector<Box> tree_boxes_;
};

}  // namespace sleight::physics
