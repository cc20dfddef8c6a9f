#include "clients/pictures/scene_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace sleight::pictures {
namespace {

using math::Quat;
using math::Vec3;

constexpr std::size_t k_disc_corners = 36;

/// From a part's frame to the scene's.
struct Frame {
  Vec3 origin_m;
  Quat turn;

  Vec3 at(const Vec3& place_m) const { return origin_m + math::rotated(turn, place_m); }
};

Frame frame_of(const scene::Part& part, const motion::Pose& pose) {
  return {.origin_m = pose.centre_m + math::rotated(pose.orientation, part.position_m),
          .turn = math::composed(pose.orientation, part.orientation)};
}

FlatPiece piece_of(std::span<const Vec3> corners_m, Seen seen) {
  FlatPiece piece;
  Vec3 middle_m{0, 0, 0};
  for (const Vec3& corner : corners_m) {
    piece.corners_mm.push_back(projected_mm(corner, seen));
    middle_m += corner;
  }
  middle_m /= static_cast<double>(corners_m.size());
  piece.depth_mm = depth_mm(middle_m, seen);
  piece.height_mm = k_mm_per_m * middle_m.z();
  return piece;
}

void add_box(const scene::Part& part, const Frame& frame, Seen seen,
             std::vector<FlatPiece>& pieces) {
  const Vec3 half_m = 0.5 * part.size_m;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      // A flat box has one face alone.
      if (side < 0 && half_m[axis] == 0) continue;
      if (half_m[(axis + 1) % 3] == 0 || half_m[(axis + 2) % 3] == 0) continue;
      Vec3 normal = Vec3::Zero();
      normal[axis] = side;
      const Vec3 seen_normal = math::rotated(frame.turn, normal);
      if (!(towards_viewer(seen_normal, seen) > k_facing_min)) continue;
      Vec3 u = Vec3::Zero();
      Vec3 v = Vec3::Zero();
      u[(axis + 1) % 3] = half_m[(axis + 1) % 3];
      v[(axis + 2) % 3] = half_m[(axis + 2) % 3];
      const Vec3 middle_m = half_m[axis] * normal;
      const std::array<Vec3, 4> corners{frame.at(middle_m + u + v), frame.at(middle_m - u + v),
                                        frame.at(middle_m - u - v), frame.at(middle_m + u - v)};
      pieces.push_back(piece_of(corners, seen));
    }
  }
}

void add_disc(const scene::Part& part, const Frame& frame, Seen seen,
              std::vector<FlatPiece>& pieces) {
  std::vector<Vec3> corners;
  for (std::size_t i = 0; i < k_disc_corners; ++i) {
    const double turn = 2 * M_PI * static_cast<double>(i) / k_disc_corners;
    corners.push_back(frame.at(0.5 * part.size_m.x() * Vec3(std::cos(turn), std::sin(turn), 0)));
  }
  pieces.push_back(piece_of(corners, seen));
}

void add_die(const scene::Part& part, const Frame& frame, Seen seen,
             std::vector<FlatPiece>& pieces) {
  const DiePose pose{.centre_mm = k_mm_per_m * frame.origin_m, .orientation = frame.turn};
  for (const SeenFace& face : seen_faces(pose, k_mm_per_m * part.size_m.x(), seen)) {
    FlatPiece piece{.corners_mm = {face.corners_mm.begin(), face.corners_mm.end()},
                    .depth_mm = depth_mm(frame.origin_m, seen),
                    .height_mm = pose.centre_mm.z(),
                    .face = face.face};
    for (const auto& pip : face.pips_mm)
      piece.pips_mm.emplace_back(pip.begin(), pip.end());
    pieces.push_back(std::move(piece));
  }
}

void add_mesh(const scene::Scene& scene, const scene::Part& part, const Frame& frame, Seen seen,
              std::span<const Vec3> offsets_m, std::vector<FlatPiece>& pieces) {
  const auto place_of = [&](std::uint32_t index) {
    const scene::Vertex& vertex = scene.vertices[index];
    Vec3 place_m = vertex.place_m;
    if (vertex.offset >= 0 && static_cast<std::size_t>(vertex.offset) < offsets_m.size())
      place_m += offsets_m[static_cast<std::size_t>(vertex.offset)];
    return frame.at(place_m);
  };
  const auto triangles = std::span(scene.triangles).subspan(part.first_triangle, part.triangles);
  for (const auto& [a, b, c] : triangles) {
    const std::array<Vec3, 3> corners{place_of(a), place_of(b), place_of(c)};
    const Vec3 normal = math::cross(Vec3(corners[1] - corners[0]), Vec3(corners[2] - corners[0]));
    const double size = math::norm(normal);
    if (!(towards_viewer(normal, seen) > k_facing_min * size)) continue;
    pieces.push_back(piece_of(corners, seen));
  }
}

}  // namespace

plot::Point projected_mm(const Vec3& place_m, Seen seen) {
  return projected(Vec3(k_mm_per_m * place_m), seen);
}

double depth_mm(const Vec3& place_m, Seen seen) {
  return k_mm_per_m * towards_viewer(place_m, seen);
}

std::vector<FlatPiece> flat_pieces(const scene::Scene& scene, const scene::Part& part,
                                   const motion::Pose& pose, Seen seen,
                                   std::span<const Vec3> offsets_m) {
  const Frame frame = frame_of(part, pose);
  std::vector<FlatPiece> pieces;
  switch (part.shape) {
    case scene::Shape::box:
      add_box(part, frame, seen, pieces);
      break;
    case scene::Shape::die:
      add_die(part, frame, seen, pieces);
      break;
    case scene::Shape::disc:
      add_disc(part, frame, seen, pieces);
      break;
    case scene::Shape::mesh:
      add_mesh(scene, part, frame, seen, offsets_m, pieces);
      break;
    case scene::Shape::sphere:
    case scene::Shape::ground:
    case scene::Shape::surface:
      break;
  }
  std::ranges::stable_sort(pieces, {}, &FlatPiece::depth_mm);
  return pieces;
}

double reach_mm(const scene::Scene& scene, std::uint32_t body) {
  double reach_m = 0;
  for (const scene::Part& part : parts_of(scene.parts, body)) {
    double part_m =
        part.shape == scene::Shape::sphere ? 0.5 * part.size_m.x() : 0.5 * math::norm(part.size_m);
    for (std::uint32_t i = 0; i < part.triangles; ++i) {
      for (const std::uint32_t vertex : scene.triangles[part.first_triangle + i])
        part_m = std::max(part_m, math::norm(scene.vertices[vertex].place_m));
    }
    reach_m = std::max(reach_m, math::norm(part.position_m) + part_m);
  }
  return k_mm_per_m * reach_m;
}

std::span<const scene::Part> parts_of(std::span<const scene::Part> parts, std::uint32_t feature) {
  const auto found = std::ranges::equal_range(parts, feature, {}, &scene::Part::feature);
  return {found.begin(), found.end()};
}

}  // namespace sleight::pictures
