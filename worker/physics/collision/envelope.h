// Computes the lower envelope of a piece's vertices along an axis.
//
// Each vertex is a line in time, given by its present place and rate along the axis. At each time,
// the envelope is the lowest line. Internal to convex_search.cpp. Thread safety: values.
#pragma once

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <span>

#include "worker/physics/collision/convex_search.h"
#include "worker/physics/collision/first_collision.h"

namespace sleight::physics::envelope {

/// A vertex's place along the axis after time h is place + rate h.
struct Line {
  double place_m;
  double rate_mps;
};

// Two lanes, as in separation.cpp.
using Pair = double __attribute__((vector_size(16)));
using Lanes = decltype(Pair{} < Pair{});

inline Pair load(const double* from) {
  Pair result;
  std::memcpy(&result, from, sizeof(result));
  return result;
}

/// Returns whether any lane of a mask is set. Without the intrinsics, GCC 12 would combine two
/// masks lane by lane.
inline bool any(Lanes mask) {
#ifdef __SSE2__
  return _mm_movemask_pd(reinterpret_cast<__m128d>(mask)) != 0;
#else
  return (mask[0] | mask[1]) != 0;
#endif
}
inline bool any(Lanes mask, Lanes other) {
#ifdef __SSE2__
  return _mm_movemask_pd(
             _mm_or_pd(reinterpret_cast<__m128d>(mask), reinterpret_cast<__m128d>(other))) != 0;
#else
  return any(mask) || any(other);
#endif
}

/// The lines of a piece's vertices along an axis. A rate is computed only when it is needed.
class Envelope {
 public:
  /// `up` is the axis's direction away from the other piece. Places are relative to the body's
  /// centre.
  Envelope(const MovingPiece& piece, const Vec3& up) : piece_(piece), up_(up) {
    const ConvexView& view = *piece.view;
    const Vec3 along = transposed_product(piece.pose.rotation, up);
    const Pair x = {along.x(), along.x()};
    const Pair y = {along.y(), along.y()};
    const Pair z = {along.z(), along.z()};
    Pair least0 = {k_forever_s, k_forever_s};
    Pair least1 = least0;
    for (std::size_t i = 0; i < view.padded_count; i += 4) {
      const Pair place0 =
          (x * load(view.xs_m + i) + y * load(view.ys_m + i)) + z * load(view.zs_m + i);
      const Pair place1 =
          (x * load(view.xs_m + i + 2) + y * load(view.ys_m + i + 2)) + z * load(view.zs_m + i + 2);
      std::memcpy(&places_m_[i], &place0, sizeof(place0));
      std::memcpy(&places_m_[i + 2], &place1, sizeof(place1));
      least0 = place0 < least0 ? place0 : least0;
      least1 = place1 < least1 ? place1 : least1;
    }
    const Pair least = least0 < least1 ? least0 : least1;
    lowest_m_ = std::min(least[0], least[1]);
  }

  double lowest_m() const { return lowest_m_; }
  /// Returns the lowest vertex. If several are equally low, returns the first of them.
  std::uint16_t lowest_vertex() const {
    const Pair lowest = {lowest_m_, lowest_m_};
    std::size_t i = 0;
    const std::size_t last = std::size_t{piece_.view->padded_count} - 4;
    while (i < last && !any(load(&places_m_[i]) == lowest, load(&places_m_[i + 2]) == lowest))
      i += 4;
    const std::size_t end = i + 3;
    while (i < end && places_m_[i] != lowest_m_)
      ++i;
    return static_cast<std::uint16_t>(std::min<std::size_t>(i, piece_.view->vertex_count - 1U));
  }

  /// Sets the axis's angular velocity from now on.
  void turn(const Vec3& axis_radps) {
    rate_ = transposed_product(piece_.pose.rotation,
                               math::cross(up_, piece_.angular_velocity_radps - axis_radps));
    fastest_mps_ = math::norm(rate_) * piece_.view->r_outer_m;
    if (first_vertex_ == k_none) first_vertex_ = lowest_vertex();
    lines_[0] = {lowest_m_, math::dot(rate_, piece_.view->vertices_m[first_vertex_])};
    line_count_ = 1;
  }

  /// Returns the line that is lowest now. After keep_until(), returns the fastest-falling line if
  /// several are equally low.
  const Line& first() const { return lines_[0]; }

  /// Keeps the lines that become lower than the first line before `until_s`. Returns whether there
  /// are any.
  bool keep_until(double until_s) {
    for_each_below(until_s, 0, [&](const Line& other) {
      lines_[line_count_++] = other;
      if (other.place_m == lowest_m_ && other.rate_mps < lines_[0].rate_mps) lines_[0] = other;
    });
    return line_count_ > 1;
  }
  /// Keeps the lines that become lower than the first line plus `margin_m` before `until_s`.
  /// Returns the kept lines, starting with the first line.
  std::span<const Line> keep_near_until(double until_s, double margin_m) {
    for_each_below(until_s, margin_m, [&](const Line& other) { lines_[line_count_++] = other; });
    return {lines_.data(), line_count_};
  }

  /// Returns the first time at which a kept line becomes lower than `current`. Stores the kept line
  /// in `next`.
  double next_after(const Line& current, Line& next) const {
    double first_s = k_forever_s;
    for (std::size_t i = 1; i < line_count_; ++i) {
      const Line& other = lines_[i];
      const double faster = current.rate_mps - other.rate_mps;
      if (!(faster > 0)) continue;
      const double above = other.place_m - current.place_m;
      // Compare above / faster < first_s without a division.
      if (above < first_s * faster) {
        first_s = above / faster;
        next = other;
      }
    }
    return first_s;
  }

 private:
  static constexpr std::size_t k_none = k_hull_points_max;

  /// Calls visit(line) for each line that is below the first line plus `margin_m` at some time up
  /// to `until_s`. If the margin is positive, the first line is one of these lines.
  template <class Visit>
  void for_each_below(double until_s, double margin_m, const Visit& visit) {
    if (!(fastest_mps_ > 0)) return;
    const ConvexView& view = *piece_.view;
    const Line start = lines_[0];
    // If a vertex is now at or above this limit, it stays above the first line plus the margin.
    const double limit_m = start.place_m + (start.rate_mps + fastest_mps_) * until_s + margin_m;
    const Pair limit = {limit_m, limit_m};
    const Pair start_m = {start.place_m + margin_m, start.place_m + margin_m};
    const Pair start_mps = {start.rate_mps, start.rate_mps};
    const Pair until = {until_s, until_s};
    const Pair x = {rate_.x(), rate_.x()};
    const Pair y = {rate_.y(), rate_.y()};
    const Pair z = {rate_.z(), rate_.z()};
    for (std::size_t i = 0; i < view.padded_count; i += 4) {
      if (!any(load(&places_m_[i]) < limit, load(&places_m_[i + 2]) < limit)) continue;
      for (std::size_t k = i; k < i + 4; k += 2) {
        const Pair place = load(&places_m_[k]);
        const Pair rate =
            (x * load(view.xs_m + k) + y * load(view.ys_m + k)) + z * load(view.zs_m + k);
        const auto below = place - start_m < (start_mps - rate) * until;
        if (!any(below)) continue;
        for (std::size_t lane = 0; lane < 2; ++lane) {
          // The padding repeats vertex 0.
          if (below[lane] == 0 || k + lane >= view.vertex_count) continue;
          visit(Line{place[lane], rate[lane]});
        }
      }
    }
  }

  const MovingPiece& piece_;
  Vec3 up_;
  Vec3 rate_ = Vec3::Zero();
  double lowest_m_;
  std::size_t first_vertex_ = k_none;  ///< the lowest vertex, once computed
  double fastest_mps_ = 0;             ///< maximum speed of a vertex along the axis
  std::size_t line_count_ = 0;
  // Uninitialised except for the entries in use.
  std::array<double, k_hull_points_max> places_m_;
  std::array<Line, k_hull_points_max + 1> lines_;
};

}  // namespace sleight::physics::envelope
