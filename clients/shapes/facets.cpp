#include "clients/shapes/facets.h"

#include <array>

#include "common/math/elementary.h"

namespace sleight::shapes {
namespace {

using math::Vec3;

// A sphere has 12 by 9 pieces, which are 192 triangles.
constexpr std::uint32_t k_round = 12;
constexpr std::uint32_t k_bands = 9;
constexpr std::uint32_t k_disc_corners = 36;

constexpr std::uint32_t k_die_faces = 6;
constexpr std::uint32_t k_pip_corners = 12;
constexpr double k_pip_radius = 0.19;  ///< in halves of a side, like the next two
constexpr double k_pip_off = 0.5;      ///< of a pip beside the middle
constexpr double k_pip_above = 0.01;

/// Visits the corners of a regular polygon about z, on a circle of this radius.
template <class Visit>
void go_round(std::uint32_t corners, const Visit& visit) {
  for (std::uint32_t i = 0; i < corners; ++i)
    visit(math::sincos(2 * M_PI * i / corners));
}

void add_sphere(std::vector<Facet>& facets, double radius_m) {
  const auto normal_at = [](std::uint32_t band, std::uint32_t i) -> Vec3 {
    if (band == 0) return {0, 0, 1};
    if (band == k_bands) return {0, 0, -1};
    const math::SinCos down = math::sincos(M_PI * band / k_bands);
    const math::SinCos round = math::sincos(2 * M_PI * (i % k_round) / k_round);
    return {down.sin * round.cos, down.sin * round.sin, down.cos};
  };
  for (std::uint32_t band = 1; band <= k_bands; ++band) {
    for (std::uint32_t i = 0; i < k_round; ++i) {
      Facet facet;
      // Pieces at the poles are triangles.
      if (band < k_bands) facet.normals.push_back(normal_at(band, i));
      facet.normals.push_back(normal_at(band, i + 1));
      if (band > 1) facet.normals.push_back(normal_at(band - 1, i + 1));
      facet.normals.push_back(normal_at(band - 1, i));
      for (const Vec3& normal : facet.normals)
        facet.corners_m.emplace_back(radius_m * normal);
      facets.push_back(std::move(facet));
    }
  }
}

/// Right-handed: the rotation from u to v is counter-clockwise from outside.
struct FaceFrame {
  Vec3 normal = Vec3::Zero();
  Vec3 u = Vec3::Zero();
  Vec3 v = Vec3::Zero();
};

FaceFrame face_frame(Eigen::Index axis, double side) {
  FaceFrame frame;
  frame.normal[axis] = side;
  frame.u[(axis + 1) % 3] = side;
  frame.v[(axis + 2) % 3] = 1;
  return frame;
}

FaceFrame frame_of_die_face(std::uint32_t face) {
  const bool is_low = face <= 3;
  return face_frame(is_low ? face - 1 : k_die_faces - face, is_low ? 1 : -1);
}

Facet side_of(const FaceFrame& face, const Vec3& half_m) {
  Facet facet;
  for (const auto& [u, v] :
       std::array<std::array<double, 2>, 4>{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}})
    facet.corners_m.emplace_back((face.normal + u * face.u + v * face.v).cwiseProduct(half_m));
  return facet;
}

void add_box(std::vector<Facet>& facets, const Vec3& half_m) {
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    // Skip sides without area; a flat box has a single face.
    if (half_m[(axis + 1) % 3] == 0 || half_m[(axis + 2) % 3] == 0) continue;
    facets.push_back(side_of(face_frame(axis, 1), half_m));
    if (half_m[axis] != 0) facets.push_back(side_of(face_frame(axis, -1), half_m));
  }
}

struct Off {
  double u;
  double v;
};

/// Returns the places of pips: the middle if the number is odd, then opposite pairs.
std::vector<Off> pip_places(std::uint32_t number) {
  constexpr double k = k_pip_off;
  constexpr std::array<Off, 6> k_pairs{{{-k, -k}, {k, k}, {-k, k}, {k, -k}, {-k, 0}, {k, 0}}};
  std::vector<Off> places;
  if (number % 2 == 1) places.push_back({0, 0});
  for (const Off& off : std::span(k_pairs).first(number - number % 2))
    places.push_back(off);
  return places;
}

void add_die(std::vector<Facet>& facets, const Vec3& half_m) {
  for (std::uint32_t number = 1; number <= k_die_faces; ++number) {
    const FaceFrame face = frame_of_die_face(number);
    facets.push_back(side_of(face, half_m));
    facets.back().face = number;
    for (const Off& pip : pip_places(number)) {
      Facet& disc = facets.emplace_back(Facet{.face = number, .is_pip = true});
      go_round(k_pip_corners, [&](const math::SinCos& round) {
        const Vec3 off = (1 + k_pip_above) * face.normal +
                         (pip.u + k_pip_radius * round.cos) * face.u +
                         (pip.v + k_pip_radius * round.sin) * face.v;
        disc.corners_m.emplace_back(off.cwiseProduct(half_m));
      });
    }
  }
}

void add_disc(std::vector<Facet>& facets, double radius_m) {
  Facet& disc = facets.emplace_back(Facet{.is_seen_from_behind = true});
  go_round(k_disc_corners, [&](const math::SinCos& round) {
    disc.corners_m.emplace_back(radius_m * round.cos, radius_m * round.sin, 0);
  });
}

}  // namespace

Vec3 place_of(const scene::Vertex& vertex, std::span<const Vec3> offsets_m) {
  if (vertex.offset < 0 || static_cast<std::size_t>(vertex.offset) >= offsets_m.size())
    return vertex.place_m;
  return vertex.place_m + offsets_m[static_cast<std::size_t>(vertex.offset)];
}

std::vector<Facet> facets_of(const scene::Scene& scene, const scene::Part& part,
                             std::span<const Vec3> offsets_m) {
  std::vector<Facet> facets;
  switch (part.shape) {
    case scene::Shape::sphere:
      add_sphere(facets, 0.5 * part.size_m.x());
      break;
    case scene::Shape::box:
      add_box(facets, 0.5 * part.size_m);
      break;
    case scene::Shape::die:
      add_die(facets, 0.5 * part.size_m);
      break;
    case scene::Shape::disc:
      add_disc(facets, 0.5 * part.size_m.x());
      break;
    case scene::Shape::mesh:
      for (const auto& [a, b, c] :
           std::span(scene.triangles).subspan(part.first_triangle, part.triangles)) {
        Facet& facet = facets.emplace_back();
        for (const std::uint32_t vertex : {a, b, c})
          facet.corners_m.push_back(place_of(scene.vertices[vertex], offsets_m));
      }
      break;
    case scene::Shape::ground:
    case scene::Shape::surface:
      break;
  }
  return facets;
}

std::uint32_t upper_face(const math::Quat& orientation) {
  std::uint32_t best = 1;
  double most = -2;
  for (std::uint32_t face = 1; face <= k_die_faces; ++face) {
    const double up = math::rotated(orientation, frame_of_die_face(face).normal).z();
    if (up > most) {
      most = up;
      best = face;
    }
  }
  return best;
}

}  // namespace sleight::shapes
