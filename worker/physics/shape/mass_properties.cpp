#include "worker/physics/shape/mass_properties.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"
#include "common/math/angle.h"

namespace sleight::physics {
namespace {

using math::cross;
using math::dot;
using math::norm;

struct Moments {
  double volume = 0;
  Vec3 first = Vec3::Zero();   ///< integral of x
  Mat3 second = Mat3::Zero();  ///< integral of x x^T
};

Mat3 outer(const Vec3& a, const Vec3& b) {
  Mat3 m;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      m(i, j) = a[i] * b[j];
  }
  return m;
}

// Returns a part's moments about its own centre. Moments about a distant origin would lose digits.
Moments moments_of(const ConvexPolyhedron& part) {
  Moments sum;
  const auto vertices = part.vertices_m();
  for (const Face& face : part.faces()) {
    const auto sides = part.sides_of(face);
    const Vec3 a = vertices[sides[0].vertex] - part.centre_m();
    for (std::size_t i = 1; i + 1 < sides.size(); ++i) {
      const Vec3 b = vertices[sides[i].vertex] - part.centre_m();
      const Vec3 c = vertices[sides[i + 1].vertex] - part.centre_m();
      const double volume = dot(a, cross(b, c)) / 6;
      const Vec3 s = a + b + c;
      sum.volume += volume;
      sum.first += volume / 4 * s;
      sum.second += volume / 20 * (outer(a, a) + outer(b, b) + outer(c, c) + outer(s, s));
    }
  }
  return sum;
}

// Starts from the quaternion's largest component (Shepperd, "Quaternion from rotation matrix",
// Journal of Guidance and Control 1, 1978).
Quat quaternion_of(const Mat3& m) {
  const double trace = m(0, 0) + m(1, 1) + m(2, 2);
  const std::array<double, 4> square{trace, m(0, 0), m(1, 1), m(2, 2)};
  const auto largest = std::max_element(square.begin(), square.end()) - square.begin();
  Quat q;
  if (largest == 0) {
    q = {1 + trace, m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1)};
  } else if (largest == 1) {
    q = {m(2, 1) - m(1, 2), 1 + m(0, 0) - m(1, 1) - m(2, 2), m(1, 0) + m(0, 1), m(2, 0) + m(0, 2)};
  } else if (largest == 2) {
    q = {m(0, 2) - m(2, 0), m(1, 0) + m(0, 1), 1 - m(0, 0) + m(1, 1) - m(2, 2), m(2, 1) + m(1, 2)};
  } else {
    q = {m(1, 0) - m(0, 1), m(2, 0) + m(0, 2), m(2, 1) + m(1, 2), 1 - m(0, 0) - m(1, 1) + m(2, 2)};
  }
  return math::normalized(q);
}

// Makes m(p, q) zero by a Jacobi rotation in the plane (p, q).
void rotate_away(Mat3& m, Mat3& axes, int p, int q) {
  if (m(p, q) == 0) return;
  const double tau = (m(q, q) - m(p, p)) / (2 * m(p, q));
  const double t = (tau >= 0 ? 1.0 : -1.0) / (std::fabs(tau) + std::sqrt(1 + tau * tau));
  const double c = 1 / std::sqrt(1 + t * t);
  const double s = t * c;
  const int r = 3 - p - q;
  const double mpr = m(p, r), mqr = m(q, r), mpq = m(p, q);
  m(p, p) -= t * mpq;
  m(q, q) += t * mpq;
  m(p, q) = m(q, p) = 0;
  m(p, r) = m(r, p) = c * mpr - s * mqr;
  m(q, r) = m(r, q) = s * mpr + c * mqr;
  for (int i = 0; i < 3; ++i) {
    const double ap = axes(i, p), aq = axes(i, q);
    axes(i, p) = c * ap - s * aq;
    axes(i, q) = s * ap + c * aq;
  }
}

Mat3 frame_of(const Vec3& x, const Vec3& y, const Vec3& z) {
  Mat3 m;
  m.col(0) = x;
  m.col(1) = y;
  m.col(2) = z;
  return m;
}

double relative_difference(double a, double b) {
  return std::fabs(a - b) / std::max(std::fabs(a), std::fabs(b));
}

struct Chosen {
  Vec3 moments = Vec3::Zero();
  Mat3 axes = Mat3::Identity();
};

base::Result<Chosen, ShapeError> axes_of_top(const PrincipalAxes& principal) {
  const Vec3& m = principal.moments;
  int odd = 2;
  double least = relative_difference(m[0], m[1]);
  for (const int axis : {0, 1}) {
    const double difference = relative_difference(m[(axis + 1) % 3], m[(axis + 2) % 3]);
    if (difference < least) {
      least = difference;
      odd = axis;
    }
  }
  // If all three moments agree, the choice above would depend on rounding. So keep the z axis.
  const double spread = (m.maxCoeff() - m.minCoeff()) / m.maxCoeff();
  if (spread <= k_moment_tolerance) odd = 2;
  if (least > k_moment_tolerance)
    return ShapeError{.kind = ShapeError::Kind::not_axial, .measured = least};
  Vec3 z = principal.axes.col(odd);
  int largest = 2;
  for (const int axis : {1, 0}) {
    if (std::fabs(z[axis]) > std::fabs(z[largest]) * (1 + 1e-9)) largest = axis;
  }
  if (z[largest] < 0) z = -z;
  // Project the given x axis (or y, if z is near x) into the plane of equal moments.
  const Vec3 guide = std::fabs(z.x()) < 0.9 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  const Vec3 x = math::normalized(guide - dot(guide, z) * z);
  const double across = 0.5 * (m[(odd + 1) % 3] + m[(odd + 2) % 3]);
  return Chosen{.moments = {across, across, m[odd]}, .axes = frame_of(x, cross(z, x), z)};
}

base::Result<Chosen, ShapeError> chosen_axes(const Mat3& inertia, InertiaSymmetry declared) {
  const PrincipalAxes principal = principal_axes(inertia);
  const Vec3& m = principal.moments;
  if (declared == InertiaSymmetry::axial) return axes_of_top(principal);
  if (declared == InertiaSymmetry::general) return Chosen{.moments = m, .axes = principal.axes};
  const double spread = (m.maxCoeff() - m.minCoeff()) / m.maxCoeff();
  if (spread > k_moment_tolerance)
    return ShapeError{.kind = ShapeError::Kind::not_spherical, .measured = spread};
  const double mean = (m[0] + m[1] + m[2]) / 3;
  return Chosen{.moments = {mean, mean, mean}};
}

}  // namespace

MassProperties mass_properties(std::span<const ConvexPolyhedron> parts, double density_kgpm3) {
  CHECK(!parts.empty());
  std::vector<Moments> moments;
  MassProperties result;
  Vec3 first = Vec3::Zero();
  for (const ConvexPolyhedron& part : parts) {
    const Moments& m = moments.emplace_back(moments_of(part));
    result.volume_m3 += m.volume;
    first += m.first + m.volume * part.centre_m();
  }
  result.mass_kg = density_kgpm3 * result.volume_m3;
  result.centre_m = first / result.volume_m3;
  // Shift the second moments to the common centre: x = d + y, where d leads from it to the part's
  // centre.
  Mat3 second = Mat3::Zero();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Moments& m = moments[i];
    const Vec3 d = parts[i].centre_m() - result.centre_m;
    second += m.second + outer(d, m.first) + outer(m.first, d) + m.volume * outer(d, d);
  }
  const double trace = second(0, 0) + second(1, 1) + second(2, 2);
  result.inertia_kgm2 = density_kgpm3 * (trace * Mat3::Identity() - second);
  return result;
}

PrincipalAxes principal_axes(const Mat3& symmetric) {
  Mat3 m = symmetric;
  m(1, 0) = m(0, 1);
  m(2, 0) = m(0, 2);
  m(2, 1) = m(1, 2);
  Mat3 axes = Mat3::Identity();
  // Convergence is quadratic, so five or six sweeps suffice. The limit is only a guard.
  constexpr int k_sweeps_max = 32;
  for (int sweep = 0; sweep < k_sweeps_max; ++sweep) {
    const double off = std::fabs(m(0, 1)) + std::fabs(m(0, 2)) + std::fabs(m(1, 2));
    const double on = std::fabs(m(0, 0)) + std::fabs(m(1, 1)) + std::fabs(m(2, 2));
    if (!(off > 0x1p-60 * on)) break;
    rotate_away(m, axes, 0, 1);
    rotate_away(m, axes, 0, 2);
    rotate_away(m, axes, 1, 2);
  }
  // Choose the order of axes whose |cosines| to the given axes have the largest sum. If tied,
  // choose the first such order.
  constexpr std::array<std::array<int, 3>, 6> k_orders{
      {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  std::array<int, 3> order = k_orders[0];
  double best = -1;
  for (const auto& candidate : k_orders) {
    const double fit = std::fabs(axes(0, candidate[0])) + std::fabs(axes(1, candidate[1])) +
                       std::fabs(axes(2, candidate[2]));
    if (fit > best * (1 + 1e-12)) {
      best = fit;
      order = candidate;
    }
  }
  PrincipalAxes result;
  result.moments = {m(order[0], order[0]), m(order[1], order[1]), m(order[2], order[2])};
  Vec3 x = axes.col(order[0]);
  Vec3 y = axes.col(order[1]);
  if (x[0] < 0) x = -x;
  if (y[1] < 0) y = -y;
  result.axes = frame_of(x, y, cross(x, y));
  return result;
}

base::Result<BodyShape, ShapeError> in_body_frame(std::span<const ConvexPolyhedron> parts,
                                                  double density_kgpm3, InertiaSymmetry declared) {
  if (parts.empty()) return ShapeError{.kind = ShapeError::Kind::no_parts};
  if (!(density_kgpm3 > 0) || !std::isfinite(density_kgpm3))
    return ShapeError{.kind = ShapeError::Kind::dimension_not_positive, .measured = density_kgpm3};
  const MassProperties mass = mass_properties(parts, density_kgpm3);
  const auto chosen = chosen_axes(mass.inertia_kgm2, declared);
  if (!chosen) return chosen.error();
  const Mat3 to_given = chosen.value().axes;
  const Mat3 to_body = to_given.transpose();
  BodyShape result;
  result.inertia = {
      .mass_kg = mass.mass_kg, .principal_kgm2 = chosen.value().moments, .symmetry = declared};
  result.frame = {.position_m = mass.centre_m, .orientation = quaternion_of(to_given)};
  const Vec3 shift = math::product(to_body, mass.centre_m);
  for (const ConvexPolyhedron& part : parts)
    result.parts.push_back(moved(part, to_body, -shift));
  return result;
}

Inertia solid_ball_inertia(double mass_kg, double radius_m) {
  const double moment = 0.4 * mass_kg * radius_m * radius_m;
  return {.mass_kg = mass_kg,
          .principal_kgm2 = Vec3(moment, moment, moment),
          .symmetry = InertiaSymmetry::spherical};
}

}  // namespace sleight::physics
