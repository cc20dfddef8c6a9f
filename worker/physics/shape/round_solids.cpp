#include "worker/physics/shape/round_solids.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "common/math/elementary.h"

namespace sleight::physics {
namespace {

/// Returns an error for the first size that isn't positive and finite.
std::optional<ShapeError> bad_size(std::initializer_list<double> sizes) {
  std::size_t index = 0;
  for (const double size : sizes) {
    if (!is_positive(size)) return not_positive(index, size);
    ++index;
  }
  return std::nullopt;
}

/// Nodes and weights of the Gauss-Legendre rule on [-1, 1] (Abramowitz and Stegun, "Handbook of
/// mathematical functions", table 25.4, n = 16).
constexpr std::array<double, 8> k_nodes{0.095012509837637440185, 0.281603550779258913230,
                                        0.458016777657227386342, 0.617876244402643748447,
                                        0.755404408355003033895, 0.865631202387831743880,
                                        0.944575023073232576078, 0.989400934991649932596};
constexpr std::array<double, 8> k_weights{0.189450610455068496285, 0.182603415044923588867,
                                          0.169156519395002538189, 0.149595988816576732081,
                                          0.124628971255533872052, 0.095158511682492784810,
                                          0.062253523938647892863, 0.027152459411754094852};

/// Returns the integral of f over an interval. At the ends, f may behave like a square root.
template <class Function>
double integral(double from, double to, const Function& f) {
  constexpr int k_panels = 4;
  const double half = 0.5 * (to - from);
  const double middle = 0.5 * (to + from);
  double sum = 0;
  for (int panel = 0; panel < k_panels; ++panel) {
    const double width = std::numbers::pi / k_panels;
    const double centre = (panel + 0.5) * width;
    for (std::size_t i = 0; i < k_nodes.size(); ++i) {
      for (const double node : {-k_nodes[i], k_nodes[i]}) {
        const double angle = centre + 0.5 * width * node;
        sum += 0.5 * width * k_weights[i] * half * math::sin(angle) *
               f(middle - half * math::cos(angle));
      }
    }
  }
  return sum;
}

struct Revolution {
  double volume_m3 = 0;
  double centre_m = 0;
  double about_m5 = 0;   ///< moments per density
  double across_m5 = 0;  ///< about the centre
};

/// Integrates a profile. REQUIRES: heights ascend, and the profile is smooth between neighbouring
/// ones.
template <class Profile>
Revolution revolution_of(std::span<const double> heights_m, const Profile& radius_m) {
  const auto over_all = [&](const auto& of_height_and_square) {
    double sum = 0;
    for (std::size_t i = 0; i + 1 < heights_m.size(); ++i) {
      sum += integral(heights_m[i], heights_m[i + 1], [&](double z) {
        const double r = radius_m(z);
        return std::numbers::pi * of_height_and_square(z, r * r);
      });
    }
    return sum;
  };
  Revolution all;
  all.volume_m3 = over_all([](double, double square) { return square; });
  all.centre_m = over_all([](double z, double square) { return z * square; }) / all.volume_m3;
  all.about_m5 = over_all([](double, double square) { return 0.5 * square * square; });
  all.across_m5 = over_all([&](double z, double square) {
    const double up = z - all.centre_m;
    return square * (0.25 * square + up * up);
  });
  return all;
}

Revolution revolution_of(std::span<const RoundPiece> pieces) {
  // Collect heights such that each piece's profile is smooth between neighbouring ones.
  std::vector<double> heights_m;
  for (const RoundPiece& piece : pieces) {
    for (const ProfileArc& arc : piece.arcs()) {
      const RoundFeature& feature = piece.features()[arc.feature];
      const double centre_m = math::dot(piece.axis(), feature.centre_m);
      heights_m.push_back(centre_m + feature.radius_m * arc.from.along);
      heights_m.push_back(centre_m + feature.radius_m * arc.to.along);
    }
  }
  std::sort(heights_m.begin(), heights_m.end());
  return revolution_of(heights_m, [&](double height_m) {
    double widest_m = 0;
    for (const RoundPiece& piece : pieces)
      widest_m = std::max(widest_m, piece.radius_at_m(height_m));
    return widest_m;
  });
}

Inertia inertia_of(const Revolution& all, double density_kgpm3) {
  const double across = density_kgpm3 * all.across_m5;
  return {.mass_kg = density_kgpm3 * all.volume_m3,
          .principal_kgm2 = {across, across, density_kgpm3 * all.about_m5},
          .symmetry = InertiaSymmetry::axial};
}

base::Result<std::vector<RoundPiece>, ShapeError> pieces_of(
    std::span<const std::vector<RoundRing>> pieces, double lowered_m) {
  std::vector<RoundPiece> made;
  for (const std::vector<RoundRing>& rings : pieces) {
    RoundDescription description;
    for (RoundRing ring : rings) {
      ring.height_m -= lowered_m;
      description.rings.push_back(ring);
    }
    auto piece = RoundPiece::make(description);
    if (!piece) return piece.error();
    made.push_back(std::move(piece).value());
  }
  return made;
}

RoundSolid re_centred(std::vector<RoundPiece> parts, const Inertia& inertia, double volume_m3) {
  RoundSolid solid{.parts = std::move(parts), .inertia = inertia, .volume_m3 = volume_m3};
  for (const RoundPiece& part : solid.parts)
    solid.foot_m = std::max(solid.foot_m, part.reach_m(-Vec3::UnitZ()));
  return solid;
}

RoundResult one_piece(std::vector<RoundRing> rings, double density_kgpm3) {
  const std::array<std::vector<RoundRing>, 1> pieces{std::move(rings)};
  return solid_of_revolution(pieces, density_kgpm3);
}

// ---- the pin ------------------------------------------------------------------------------------

constexpr double k_inch_m = 0.0254;

struct ProfilePoint {
  double height_in;
  double radius_in;
};
/// Heights and radii. Source: United States Bowling Congress, "Equipment specifications and
/// certifications manual", pin specifications.
constexpr std::array<ProfilePoint, 14> k_pin{{{0, 2.031 / 2},
                                              {0.75, 2.828 / 2},
                                              {2.25, 3.906 / 2},
                                              {3.375, 4.510 / 2},
                                              {4.5, 4.766 / 2},
                                              {5.875, 4.563 / 2},
                                              {7.25, 3.703 / 2},
                                              {8.625, 2.472 / 2},
                                              {9.375, 1.965 / 2},
                                              {10, 1.797 / 2},
                                              {10.875, 1.870 / 2},
                                              {11.75, 2.094 / 2},
                                              {12.625, 2.406 / 2},
                                              {13.5, 2.547 / 2}}};
constexpr double k_pin_height_in = 15;
static_assert(k_bowling_pin_height_m == k_pin_height_in * k_inch_m);
constexpr double k_dome_in = 1.273;
constexpr double k_rim_in = 5.0 / 32;

/// Returns the second derivatives of the cubic spline through the points. The spline is free at the
/// foot and level at the top (Press and others, "Numerical recipes", 3.3).
std::array<double, k_pin.size()> pin_bends() {
  constexpr std::size_t n = k_pin.size();
  std::array<double, n> bend{};
  std::array<double, n> carry{};
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double before = k_pin[i].height_in - k_pin[i - 1].height_in;
    const double after = k_pin[i + 1].height_in - k_pin[i].height_in;
    const double share = before / (before + after);
    const double p = share * bend[i - 1] + 2;
    bend[i] = (share - 1) / p;
    const double change = (k_pin[i + 1].radius_in - k_pin[i].radius_in) / after -
                          (k_pin[i].radius_in - k_pin[i - 1].radius_in) / before;
    carry[i] = (6 * change / (before + after) - share * carry[i - 1]) / p;
  }
  const double last = k_pin[n - 1].height_in - k_pin[n - 2].height_in;
  const double slope = (k_pin[n - 1].radius_in - k_pin[n - 2].radius_in) / last;
  const double end = 3 / last * (0 - slope);
  bend[n - 1] = (end - 0.5 * carry[n - 2]) / (0.5 * bend[n - 2] + 1);
  for (std::size_t i = n - 1; i-- > 0;)
    bend[i] = bend[i] * bend[i + 1] + carry[i];
  return bend;
}

double pin_radius_in(double height_in) {
  if (height_in < 0 || height_in > k_pin_height_in) return 0;
  if (height_in > k_pin.back().height_in) {
    const double above_in = std::max(0.0, height_in - (k_pin_height_in - k_dome_in));
    return std::sqrt(std::max(0.0, k_dome_in * k_dome_in - above_in * above_in));
  }
  static const std::array<double, k_pin.size()> k_bends = pin_bends();
  std::size_t i = 1;
  while (k_pin[i].height_in < height_in)
    ++i;
  const double width = k_pin[i].height_in - k_pin[i - 1].height_in;
  const double a = (k_pin[i].height_in - height_in) / width;
  const double b = 1 - a;
  return a * k_pin[i - 1].radius_in + b * k_pin[i].radius_in +
         ((a * a * a - a) * k_bends[i - 1] + (b * b * b - b) * k_bends[i]) * width * width / 6;
}

/// Returns a ring whose outermost points are on the profile.
RoundRing pin_ring(double height_in) {
  constexpr double k_edge_in = 0.01;
  return {.height_m = height_in * k_inch_m,
          .circle_m = (pin_radius_in(height_in) - k_edge_in) * k_inch_m,
          .radius_m = k_edge_in * k_inch_m};
}

std::vector<RoundRing> pin_rings(std::initializer_list<double> heights_in) {
  std::vector<RoundRing> rings;
  for (const double height_in : heights_in)
    rings.push_back(pin_ring(height_in));
  return rings;
}

}  // namespace

RoundResult solid_of_revolution(std::span<const std::vector<RoundRing>> pieces,
                                double density_kgpm3) {
  if (pieces.empty()) return ShapeError{.kind = ShapeError::Kind::no_parts};
  if (!is_positive(density_kgpm3)) return not_positive(0, density_kgpm3);
  const auto given = pieces_of(pieces, 0);
  if (!given) return given.error();
  const Revolution all = revolution_of(given.value());
  auto centred = pieces_of(pieces, all.centre_m);
  if (!centred) return centred.error();
  return re_centred(std::move(centred).value(), inertia_of(all, density_kgpm3), all.volume_m3);
}

RoundResult capsule(double radius_m, double between_m, double density_kgpm3) {
  if (const auto bad = bad_size({radius_m, between_m, density_kgpm3})) return *bad;
  return one_piece({{.height_m = -0.5 * between_m, .circle_m = 0, .radius_m = radius_m},
                    {.height_m = 0.5 * between_m, .circle_m = 0, .radius_m = radius_m}},
                   density_kgpm3);
}

RoundResult cylinder(double radius_m, double height_m, double edge_m, double density_kgpm3) {
  if (const auto bad = bad_size({radius_m, height_m, edge_m, density_kgpm3})) return *bad;
  if (edge_m > std::min(radius_m, 0.5 * height_m)) return not_positive(2, edge_m);
  const double up_m = 0.5 * height_m - edge_m;
  const double circle_m = radius_m - edge_m;
  return one_piece({{.height_m = -up_m, .circle_m = circle_m, .radius_m = edge_m},
                    {.height_m = up_m, .circle_m = circle_m, .radius_m = edge_m}},
                   density_kgpm3);
}

RoundResult cone(double radius_m, double height_m, double edge_m, double density_kgpm3) {
  if (const auto bad = bad_size({radius_m, height_m, edge_m, density_kgpm3})) return *bad;
  if (edge_m > std::min(radius_m, 0.5 * height_m)) return not_positive(2, edge_m);
  return one_piece({{.height_m = edge_m, .circle_m = radius_m - edge_m, .radius_m = edge_m},
                    {.height_m = height_m - edge_m, .circle_m = 0, .radius_m = edge_m}},
                   density_kgpm3);
}

RoundResult coin(double radius_m, double thickness_m, double density_kgpm3) {
  if (const auto bad = bad_size({radius_m, thickness_m, density_kgpm3})) return *bad;
  return cylinder(radius_m, thickness_m, 0.25 * thickness_m, density_kgpm3);
}

RoundResult rounded_box(const Vec3& sides_m, double edge_m, double density_kgpm3) {
  if (const auto bad = bad_size({sides_m.x(), sides_m.y(), sides_m.z(), edge_m, density_kgpm3}))
    return *bad;
  if (2 * edge_m > sides_m.minCoeff()) return not_positive(3, edge_m);
  const Vec3 core_m = sides_m - Vec3::Constant(2 * edge_m);
  RoundDescription description;
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) {
      for (const double z : {-0.5, 0.5}) {
        description.balls.push_back(
            {.centre_m = {x * core_m.x(), y * core_m.y(), z * core_m.z()}, .radius_m = edge_m});
      }
    }
  }
  auto piece = RoundPiece::make(description);
  if (!piece) return piece.error();
  // Each section perpendicular to an axis is a rectangle with rounded corners.
  double volume_m3 = 0;
  Vec3 squares = Vec3::Zero();  // integrals of x^2, y^2, z^2
  for (int axis = 0; axis < 3; ++axis) {
    const double b = core_m[(axis + 1) % 3];
    const double c = core_m[(axis + 2) % 3];
    const auto area_m2 = [&](double x) {
      const double out_m = std::max(0.0, std::fabs(x) - 0.5 * core_m[axis]);
      const double s = std::sqrt(std::max(0.0, edge_m * edge_m - out_m * out_m));
      return b * c + 2 * s * (b + c) + std::numbers::pi * s * s;
    };
    const double inner_m = 0.5 * core_m[axis];
    const double outer_m = 0.5 * sides_m[axis];
    const auto twice = [&](const auto& f) {
      return 2 * (integral(0, inner_m, f) + integral(inner_m, outer_m, f));
    };
    volume_m3 = twice(area_m2);
    squares[axis] = twice([&](double x) { return x * x * area_m2(x); });
  }
  const Vec3 moments = density_kgpm3 * Vec3(squares.y() + squares.z(), squares.x() + squares.z(),
                                            squares.x() + squares.y());
  RoundSolid solid{.parts = {std::move(piece).value()},
                   .inertia = {.mass_kg = density_kgpm3 * volume_m3,
                               .principal_kgm2 = moments,
                               .symmetry = InertiaSymmetry::general},
                   .volume_m3 = volume_m3,
                   .foot_m = 0.5 * sides_m.z()};
  if (sides_m.x() == sides_m.y()) {
    solid.inertia.principal_kgm2.y() = moments.x();
    solid.inertia.symmetry = InertiaSymmetry::axial;
    if (sides_m.x() == sides_m.z()) {
      solid.inertia.principal_kgm2.z() = moments.x();
      solid.inertia.symmetry = InertiaSymmetry::spherical;
    }
  }
  return solid;
}

RoundResult bowling_pin(double mass_kg) {
  if (!is_positive(mass_kg)) return not_positive(0, mass_kg);
  // The rim's outermost points are inside the profile, because the line to the next ring is outside
  // it.
  constexpr double k_inside_in = 0.008;
  std::vector<RoundRing> belly =
      pin_rings({0.75, 1.5, 2.25, 2.8, 3.375, 3.9, 4.5, 5.2, 5.875, 6.55, 7.25, 7.9});
  belly.push_back({.height_m = k_rim_in * k_inch_m,
                   .circle_m = (pin_radius_in(k_rim_in) - k_rim_in - k_inside_in) * k_inch_m,
                   .radius_m = k_rim_in * k_inch_m});
  std::vector<RoundRing> head = pin_rings({12.2, 12.625, 13.1, 13.5});
  head.push_back({.height_m = (k_pin_height_in - k_dome_in) * k_inch_m,
                  .circle_m = 0,
                  .radius_m = k_dome_in * k_inch_m});
  std::vector<std::vector<RoundRing>> pieces{belly};
  // The neck is concave. So the neck is divided into parts, one between each two neighbouring
  // heights.
  constexpr std::array k_neck_in{7.9, 8.625, 9.0, 9.375, 9.7, 10.2, 10.875, 11.5, 12.2};
  for (std::size_t i = 0; i + 1 < k_neck_in.size(); ++i)
    pieces.push_back(pin_rings({k_neck_in[i], k_neck_in[i + 1]}));
  pieces.push_back(head);
  std::vector<double> heights_m{0, k_rim_in * k_inch_m};
  for (std::size_t i = 1; i < k_pin.size(); ++i)
    heights_m.push_back(k_pin[i].height_in * k_inch_m);
  heights_m.push_back((k_pin_height_in - k_dome_in) * k_inch_m);
  heights_m.push_back(k_pin_height_in * k_inch_m);
  const Revolution all = revolution_of(heights_m, [&](double height_m) {
    const double below_m = k_rim_in * k_inch_m - height_m;
    if (below_m <= 0) return bowling_pin_radius_m(height_m);
    const double r = belly.back().radius_m;
    return belly.back().circle_m + std::sqrt(std::max(0.0, r * r - below_m * below_m));
  });
  auto parts = pieces_of(pieces, all.centre_m);
  if (!parts) return parts.error();
  return re_centred(std::move(parts).value(), inertia_of(all, mass_kg / all.volume_m3),
                    all.volume_m3);
}

double bowling_pin_radius_m(double height_m) {
  return k_inch_m * pin_radius_in(height_m / k_inch_m);
}

}  // namespace sleight::physics
