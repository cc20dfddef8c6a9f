// Static geometry as bodies meet it, and what of it lies near a box.
//
// Idea. Spheres meet features: faces, edges and vertices, each with its region (sphere_search.h).
// Bodies of convex parts meet convex pieces: half-spaces, polyhedra, triangles (convex_search.h).
// Each plane is one of both, under the same index.
//
// A feature is touched where the centre's closest point lies on it. So a face's region is the prism
// above it and not below; an edge's lies between its ends and beyond the sides of the faces at it;
// a vertex's beyond the ends of all its edges. A closed mesh is met from outside: edges where it is
// hollow or flat are left out, since a sphere touches the faces beside them first. An open mesh is
// a sheet that is met from both sides: each triangle is two faces, back to back, and an edge that
// is hollow from one side is met from the other, so only flat ones are left out. The same region
// serves both: of the two wedges between the sides it is the one on the convex side.
//
// Invariants
//   1. Planes come first, then features of convexes, then those of meshes: per mesh its faces (of a
//      sheet each twice), then edges, then vertices, each in the mesh's order. What of these can't
//      be met has a region that holds nothing: so a feature keeps its index when vertices move.
//   2. Every point outside of the solids lies in the region of the feature that it is closest to.
//      Neighbours share their borders bit for bit, faces and vertices reach over them by some
//      rounding errors: else a sphere might slip through a crack that is one of these wide. Where
//      two regions overlap, gaps and normals agree to rounding.
//   3. Features are there only if some body is a sphere, convex pieces only if some body is not.
// Building takes some 35 ns per feature and 130 ns per triangle as a piece; refresh some 20 ns for
// each feature about the vertices that moved. Thread safety: const functions may run at once.
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

/// Whether some of a box is not outside of a plane.
bool reaches(const HalfSpace& outside, const Box& box);

/// As it is called in errors: "plane 'floor'", or "plane 0" without a name.
std::string name_of_static(std::string_view kind, const std::string& given, std::size_t index);

/// What a piece or feature belongs to.
struct StaticOwner {
  std::uint32_t name = 0;  ///< index of its name
  MaterialId material{};
};

/// Where the centre of a sphere may be while the sphere stays in a box, and k_touch_m more on all
/// sides, which covers rounding.
struct CentreRange {
  CentreRange(const Box& box, double radius_m);
  Vec3 middle_m;
  Vec3 half_m;
  double reach_m;  ///< the radius, and what counts as a touch
  double away_m;   ///< from the middle, of what is within reach of any corner

  /// How far it goes along a direction from its middle.
  double spread_m(const Vec3& direction) const {
    return (std::fabs(direction.x()) * half_m.x() + std::fabs(direction.y()) * half_m.y()) +
           std::fabs(direction.z()) * half_m.z();
  }
};

class StaticGeometry {
 public:
  /// Shares the scene's polyhedra and meshes. REQUIRES: error_of(scene) has none.
  explicit StaticGeometry(const Scene& scene) { assign(scene); }
  /// Equals a new one afterwards, and reuses its memory: several times faster where the system
  /// hands out and takes back memory by pages.
  void assign(const Scene& scene);
  /// Vertices of a mesh, given by its place in the scene, have moved. Equals a new geometry
  /// afterwards; reads the mesh's last move. REQUIRES: only spheres meet it.
  void refresh(std::size_t mesh);
  // Pieces point into arrays of this object, which stay where they are when it is moved.
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
  /// Whether nothing can meet a feature as its mesh is now.
  bool is_absent(FeatureId index) const { return is_absent(features_[index]); }
  static bool is_absent(const SphereFeature& feature) {
    return feature.regions_end == k_nothing + 1;
  }
  /// Of a feature itself, wherever its mesh's slack lets its vertices be. REQUIRES: not a plane.
  const Box& feature_box(FeatureId index) const { return feature_boxes_[index - plane_count_]; }
  /// How often refresh has made boxes of features anew: each time that a vertex was outside of its
  /// slack.
  std::uint64_t boxes_made() const { return boxes_made_; }
  /// Those that the last refresh wrote anew; some may come twice.
  std::span<const FeatureId> refreshed() const { return refreshed_; }
  /// What of a mesh, by its place in the scene, is otherwise once a vertex has moved, as long as
  /// border_m stays; all is, if not.
  struct About {
    std::vector<FeatureId> features;  ///< that hang on it
    /// Faces that do not, beside some that do: theirs is otherwise only where an edge between has
    /// become flat, or is flat no more.
    std::vector<FeatureId> beside;
    std::vector<std::uint32_t> edges;  ///< of the mesh: those that may
  };
  About about(std::size_t mesh, std::uint32_t vertex) const;
  /// How far a mesh's regions reach over their borders: by rounding, at its greatest coordinate.
  double border_m(std::size_t mesh) const { return meshes_[mesh].margins.border_m; }
  const HalfSpace& plane(PieceId index) const { return planes_[index]; }
  /// REQUIRES: plane_count() <= index < piece_count().
  const MovingPiece& piece(PieceId index) const { return pieces_[index - plane_count_]; }

  /// A plane's, or null. Of features and pieces alike, as planes come first in both.
  const FrictionMap* friction_map(StaticId index) const {
    return index < friction_maps_.size() ? friction_maps_[index].get() : nullptr;
  }
  /// Friction where something touches a feature or a piece; `otherwise` is the table's.
  double friction_at(StaticId index, const Vec3& point_m, double otherwise) const {
    const FrictionMap* map = friction_map(index);
    return map == nullptr ? otherwise : map->friction_at(point_m).value_or(otherwise);
  }

  MaterialId material_of_feature(FeatureId index) const { return feature_owners_[index].material; }
  MaterialId material_of_piece(PieceId index) const { return piece_owners_[index].material; }
  /// For people.
  const std::string& name_of_feature(FeatureId index) const {
    return names_[feature_owners_[index].name];
  }
  const std::string& name_of_piece(PieceId index) const {
    return names_[piece_owners_[index].name];
  }

  /// Appends the indices of the features that a sphere of this radius may meet while its centre
  /// stays in a box, in ascending order.
  void features_near(const Box& box, double radius_m, std::vector<StaticId>& found) const;
  /// The same of pieces that a box overlaps.
  void pieces_near(const Box& box, std::vector<StaticId>& found) const;

  /// Whether a sphere may meet a feature: its centre comes into the feature's region, and near
  /// enough. Inline, since this is asked for each feature near each new box.
  bool may_meet(FeatureId index, const CentreRange& centre) const {
    const SphereFeature& one = features_[index];
    const Vec3 from = centre.middle_m - one.point_m;
    const double along_m = math::dot(one.direction, from);  // of a vertex 0
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
  /// Whether a piece reaches into a box.
  bool piece_overlaps(PieceId index, const Box& box) const {
    return index < plane_count_ ? reaches(planes_[index], box)
                                : overlap(piece_boxes_[index - plane_count_], box);
  }

  /// The name of the solid that holds a point: a plane's lower side, a polyhedron, a closed mesh.
  /// Null if none does. A body that starts wholly inside of one touches no feature of its surface.
  /// The answer is exact but for points within rounding of a surface. Not fast: some 60 ns per
  /// triangle of each closed mesh in whose box it is.
  const std::string* solid_at(const Vec3& point_m) const;

 private:
  /// The first of all sides: a region of it alone holds nothing.
  static constexpr std::uint32_t k_nothing = 0;

  struct Sizes;
  /// How far faces and vertices reach over their borders.
  struct Margins {
    double border_m = 0;
    double flat_m = 0;  ///< over edges that count as flat, though they may not quite be
  };
  void clear();
  void reserve(const Sizes& sizes);
  Margins margins_of(std::span<const Vec3> vertices_m) const;
  void add_plane(const StaticPlane& plane);
  void add_convex(const StaticConvex& convex);
  void add_mesh(const StaticMesh& mesh);
  void add_features(const ConvexView& view, StaticOwner owner);
  void add_features(const StaticMesh& placed, StaticOwner owner);
  /// Where a mesh's features and their regions are.
  struct MeshPlace {
    std::shared_ptr<const TriangleMesh> mesh;
    std::size_t solid = 0;  ///< if it is closed
    bool closed = false;
    double slack_m = 0;
    Margins margins;
    std::vector<Vec3> homes_m{};  ///< of the vertices, when boxes were made; none without slack
    std::uint32_t first_face = 0, first_edge = 0, first_vertex = 0;
    std::uint32_t face_sides = 0, edge_sides = 0;
    std::vector<std::uint32_t> vertex_sides{};  ///< of vertex v from [v] to [v + 1]
    /// By triangle: how far it reaches over each of its borders.
    std::vector<std::array<double, 3>> face_margins_m{};
    /// By edge: its own among the sides of its ends.
    std::vector<std::array<std::uint32_t, 2>> end_sides{};
    bool keeps_side = false;  ///< no move within the slack turns it inside out
  };
  void lay_out(MeshPlace& place);
  void write_margins(MeshPlace& place, std::uint32_t triangle) const;
  // Of some of the mesh's faces, edges and vertices, by their numbers there.
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

  /// What is solid inside.
  struct Solid {
    StaticOwner owner;
    std::shared_ptr<const ConvexPolyhedron> polyhedron;  ///< or
    std::shared_ptr<const TriangleMesh> mesh;
    Box box{};            ///< of the mesh
    bool hollow = false;  ///< the mesh's normals point inwards: outside of it all is solid
  };

  static bool is_solid_at(const Solid& solid, const Vec3& point_m);

  bool for_spheres_ = false;
  bool for_pieces_ = false;
  double radius_m_max_ = 0;  ///< of the scene's spheres
  std::size_t plane_count_ = 0;
  std::vector<HalfSpace> planes_;
  std::vector<std::shared_ptr<const FrictionMap>> friction_maps_;  ///< none if no plane has one
  std::vector<SphereFeature> features_;
  std::vector<RegionSide> sides_;
  std::vector<StaticOwner> feature_owners_;
  std::vector<Box> feature_boxes_;        ///< from plane_count_ on
  std::vector<TrianglePiece> triangles_;  ///< never grows beyond what was reserved
  std::vector<ConvexView> views_;         ///< the same
  std::vector<MovingPiece> pieces_;
  std::vector<StaticOwner> piece_owners_;
  std::vector<Box> piece_boxes_;  ///< from plane_count_ on
  std::vector<MeshPlace> meshes_;
  BoxTree feature_tree_;
  std::vector<FeatureId> in_feature_tree_;  ///< by place there: which feature
  BoxTree piece_tree_;
  std::vector<std::string> names_;
  std::vector<Solid> solids_;
  std::uint64_t boxes_made_ = 0;
  std::vector<FeatureId> refreshed_;
  std::vector<std::uint32_t> beside_;  ///< triangles, while refreshing
  std::vector<std::uint32_t> every_;   ///< number there is of a mesh's faces, edges or vertices
  // Room for building.
  std::vector<Box> corner_boxes_;
  std::vector<Box> tree_boxes_;
};

}  // namespace sleight::physics
