#include "clients/browse/inside.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace sleight::browse {
namespace {

/// A parabola has a rising and a falling branch, each with at most one interval between the bounds.
struct Stretches {
  std::array<Stretch, 2> held{};
  std::size_t count = 0;

  void add(double from_s, double to_s) {
    // Two branches that meet between the bounds form one interval.
    if (count > 0 && held[count - 1].to_s == from_s) {
      held[count - 1].to_s = to_s;
    } else {
      held[count++] = {from_s, to_s};
    }
  }
};

/// One coordinate of a piece as a function of the time since the piece's start.
struct Parabola {
  double p = 0;
  double v = 0;
  double a = 0;

  double at(double s) const { return p + s * (v + 0.5 * a * s); }

  /// Returns when a branch from s0 to s1 crosses c. REQUIRES: the ends are below and above c.
  double crossing(double c, double s0, double s1) const {
    const double below = p - c;
    double s = 0;
    if (a == 0) {
      s = -below / v;
    } else {
      // The two roots of a/2 s^2 + v s + `below`, in the form without cancellation.
      const double root = std::sqrt(std::max(0.0, v * v - 2 * a * below));
      const double q = -(v + std::copysign(root, v));
      const double first = q / a;
      const double second = q == 0 ? first : 2 * below / q;
      const double middle = 0.5 * (s0 + s1);
      const bool is_second = std::isfinite(middle)
                                 ? std::abs(second - middle) < std::abs(first - middle)
                                 : second > first;
      s = is_second ? second : first;
    }
    return std::clamp(s, s0, s1);
  }

  /// Adds the interval in which a branch from s0 to s1 is between the bounds.
  void add_branch(double low, double high, double s0, double s1, Stretches& stretches) const {
    const double at0 = at(s0);
    const double at1 = std::isfinite(s1) ? at(s1) : std::copysign(s1, a != 0 ? a : v);
    if (std::max(at0, at1) < low || std::min(at0, at1) > high) return;
    const auto bound = [&](double value) { return value < low ? low : high; };
    const bool is_in0 = at0 >= low && at0 <= high;
    const bool is_in1 = at1 >= low && at1 <= high;
    const double from = is_in0 ? s0 : crossing(bound(at0), s0, s1);
    const double to = is_in1 ? s1 : crossing(bound(at1), s0, s1);
    stretches.add(from, std::max(from, to));
  }

  Stretches between(double low, double high, double s0, double s1) const {
    Stretches stretches;
    if (v == 0 && a == 0) {
      if (p >= low && p <= high) stretches.add(s0, s1);
      return stretches;
    }
    const double turn = a == 0 ? s0 : -v / a;
    if (turn > s0 && turn < s1) {
      add_branch(low, high, s0, turn, stretches);
      add_branch(low, high, turn, s1, stretches);
    } else {
      add_branch(low, high, s0, s1, stretches);
    }
    return stretches;
  }
};

}  // namespace

std::optional<double> first_inside(const Piece& piece, double end_s, const Box& box,
                                   const Stretch& when) {
  const double s0 = std::max(0.0, when.from_s - piece.start_s);
  const double s1 = std::min(end_s, when.to_s) - piece.start_s;
  if (!(s0 <= s1)) return std::nullopt;
  std::array<Stretches, 3> axes;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    const Parabola parabola{.p = piece.position_m[axis],
                            .v = piece.velocity_mps[axis],
                            .a = piece.acceleration_mps2[axis]};
    axes[i] = parabola.between(box.low_m[axis], box.high_m[axis], s0, s1);
    if (axes[i].count == 0) return std::nullopt;
  }
  std::optional<double> first;
  for (std::size_t x = 0; x < axes[0].count; ++x) {
    for (std::size_t y = 0; y < axes[1].count; ++y) {
      for (std::size_t z = 0; z < axes[2].count; ++z) {
        const std::array of{axes[0].held[x], axes[1].held[y], axes[2].held[z]};
        const double from = std::max({of[0].from_s, of[1].from_s, of[2].from_s});
        const double to = std::min({of[0].to_s, of[1].to_s, of[2].to_s});
        if (from <= to && (!first || from < *first)) first = from;
      }
    }
  }
  if (!first) return std::nullopt;
  return piece.start_s + *first;
}

std::optional<double> first_inside(std::span<const Piece> pieces, const Box& box,
                                   const Stretch& when) {
  const Piece* in_force = piece_at(pieces, when.from_s);
  std::size_t i = in_force == nullptr ? 0 : static_cast<std::size_t>(in_force - pieces.data());
  for (; i < pieces.size() && pieces[i].start_s <= when.to_s; ++i) {
    const double end_s =
        i + 1 < pieces.size() ? pieces[i + 1].start_s : std::numeric_limits<double>::infinity();
    if (const auto found = first_inside(pieces[i], end_s, box, when)) return found;
  }
  return std::nullopt;
}

}  // namespace sleight::browse
