#include "clients/pictures/die_drawing.h"

#include <cmath>
#include <span>

#include "common/base/check.h"
#include "common/math/elementary.h"

namespace sleight::pictures {
namespace {

using math::Vec3;

constexpr double k_pip_radius = 0.19;  ///< in halves of a side
constexpr double k_pip_off = 0.5;      ///< of a pip beside the middle, likewise

struct Off {
  double u;
  double v;
};

/// The outward normal in the die's frame, and two directions along the face.
struct FaceFrame {
  Vec3 normal;
  Vec3 u;
  Vec3 v;
};

FaceFrame frame_of(std::uint32_t face) {
  CHECK(face >= 1 && face <= k_die_faces);
  const bool is_low = face <= 3;
  const auto axis = static_cast<Eigen::Index>(is_low ? face - 1 : k_die_faces - face);
  FaceFrame frame{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  frame.normal[axis] = is_low ? 1 : -1;
  frame.u[(axis + 1) % 3] = 1;
  frame.v[(axis + 2) % 3] = 1;
  return frame;
}

/// The middle if the number is odd, then pairs opposite each other.
std::vector<Off> pips_of(std::uint32_t face) {
  constexpr double k = k_pip_off;
  constexpr std::array<Off, 6> k_pairs{{{-k, -k}, {k, k}, {-k, k}, {k, -k}, {-k, 0}, {k, 0}}};
  std::vector<Off> pips;
  if (face % 2 == 1) pips.push_back({0, 0});
  for (const Off& off : std::span(k_pairs).first(face - face % 2))
    pips.push_back(off);
  return pips;
}

}  // namespace

double towards_viewer(const Vec3& direction, Seen seen) {
  return seen == Seen::from_above ? direction.z() : -direction.y();
}

plot::Point projected(const Vec3& place_mm, Seen seen) {
  return {place_mm.x(), seen == Seen::from_above ? place_mm.y() : place_mm.z()};
}

std::vector<SeenFace> seen_faces(const DiePose& pose, double side_mm, Seen seen) {
  const double half_mm = 0.5 * side_mm;
  std::vector<SeenFace> faces;
  for (std::uint32_t face = 1; face <= k_die_faces; ++face) {
    const FaceFrame frame = frame_of(face);
    const Vec3 normal = math::rotated(pose.orientation, frame.normal);
    if (!(towards_viewer(normal, seen) > k_facing_min)) continue;
    const Vec3 u = math::rotated(pose.orientation, frame.u);
    const Vec3 v = math::rotated(pose.orientation, frame.v);
    const auto at = [&](const Off& off) {
      const Vec3 place_mm = pose.centre_mm + half_mm * (normal + off.u * u + off.v * v);
      return projected(place_mm, seen);
    };
    SeenFace seen_face{.face = face,
                       .corners_mm = {at({1, 1}), at({-1, 1}), at({-1, -1}), at({1, -1})}};
    for (const Off& pip : pips_of(face)) {
      auto& corners = seen_face.pips_mm.emplace_back();
      for (std::size_t i = 0; i < k_pip_corners; ++i) {
        const math::SinCos turn = math::sincos(2 * M_PI * static_cast<double>(i) / k_pip_corners);
        corners[i] = at({pip.u + k_pip_radius * turn.cos, pip.v + k_pip_radius * turn.sin});
      }
    }
    faces.push_back(std::move(seen_face));
  }
  return faces;
}

std::uint32_t upper_face(const math::Quat& orientation) {
  std::uint32_t best = 1;
  double most = -2;
  for (std::uint32_t face = 1; face <= k_die_faces; ++face) {
    const double up = math::rotated(orientation, frame_of(face).normal).z();
    if (up > most) {
      most = up;
      best = face;
    }
  }
  return best;
}

}  // namespace sleight::pictures
