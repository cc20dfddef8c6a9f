#include "worker/physics/scene/friction_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "common/math/vector.h"
#include "worker/physics/collision/sphere_search.h"
#include "worker/physics/event/tolerances.h"

namespace sleight::physics {
namespace {

constexpr double k_friction_max = 1e6;

/// A coordinate as a function of time, with constant second derivative.
struct Line {
  double place = 0;
  double rate = 0;
  double bend = 0;
  double at(double s) const { return place + s * (rate + 0.5 * s * bend); }
};

struct Range {
  double low = 0;
  double high = 0;
};

Range range_of(const Line& line, double until_s) {
  const double last = line.at(until_s);
  Range range{std::min(line.place, last), std::max(line.place, last)};
  const double turn_s = line.bend != 0 ? -line.rate / line.bend : -1;
  if (turn_s > 0 && turn_s < until_s) {
    range.low = std::min(range.low, line.at(turn_s));
    range.high = std::max(range.high, line.at(turn_s));
  }
  return range;
}

/// Round x down or up, by one unit in the float's last place or slightly more.
float below(double x) {
  return std::nextafter(static_cast<float>(x), -std::numeric_limits<float>::infinity());
}
float above(double x) {
  return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
}
Box box_of(const Range& u, const Range& v) {
  return {.low_m = {below(u.low), below(v.low), 0}, .high_m = {above(u.high), above(v.high), 0}};
}

bool holds(double low, double high, double x) {
  return low <= x && x < high;
}

/// Returns the time at which a coordinate passes one of two bounds. It starts between them.
double leaves_s(const Line& line, double low, double high) {
  return std::min(first_fall_s(std::max(0.0, line.place - low), line.rate, line.bend),
                  first_fall_s(std::max(0.0, high - line.place), -line.rate, -line.bend));
}

/// Times in ascending order: up to two crossings of each of four sides, and the end.
struct FewTimes {
  std::array<double, 9> s{};
  std::size_t count = 0;

  void add(double time_s) {
    std::size_t i = count++;
    for (; i > 0 && s[i - 1] > time_s; --i)
      s[i] = s[i - 1];
    s[i] = time_s;
  }
};

/// Adds the times at which a coordinate equals a value.
void add_crossings(const Line& line, double value, double until_s, FewTimes& times) {
  const auto add = [&](double s) {
    if (s > 0 && s < until_s) times.add(s);
  };
  const double excess = line.place - value;
  if (line.bend == 0) {
    if (line.rate != 0) add(-excess / line.rate);
    return;
  }
  const double discriminant = line.rate * line.rate - 2 * line.bend * excess;
  if (!(discriminant >= 0)) return;
  // Compute the root of larger magnitude first, to avoid cancellation.
  const double sum = -(line.rate + std::copysign(std::sqrt(discriminant), line.rate));
  add(sum / line.bend);
  if (sum != 0) add(2 * excess / sum);
}

/// Returns the time at which a point first enters a rectangle, but at most until_s. The point
/// starts outside.
double enters_s(const Line& u, const Line& v, const FrictionRectangle& rectangle, double until_s) {
  // Between two successive times, the point crosses no side. So test whether the point is inside at
  // their middle.
  FewTimes times;
  add_crossings(u, rectangle.u_min_m, until_s, times);
  add_crossings(u, rectangle.u_max_m, until_s, times);
  add_crossings(v, rectangle.v_min_m, until_s, times);
  add_crossings(v, rectangle.v_max_m, until_s, times);
  times.add(until_s);
  double from_s = 0;
  for (const double to_s : std::span(times.s).first(times.count)) {
    const double middle_s = 0.5 * (from_s + to_s);
    if (holds(rectangle.u_min_m, rectangle.u_max_m, u.at(middle_s)) &&
        holds(rectangle.v_min_m, rectangle.v_max_m, v.at(middle_s)))
      return from_s;
    from_s = to_s;
  }
  return until_s;
}

bool is_unit(const Vec3& v) {
  return std::fabs(math::norm(v) - 1) < 1e-12;
}

bool is_interval(double low, double high) {
  return low >= -k_coordinate_m_max && low < high && high <= k_coordinate_m_max;
}

}  // namespace

base::Result<FrictionMap, std::string> FrictionMap::make(
    const MapFrame& frame, std::vector<FrictionRectangle> rectangles) {
  if (!is_unit(frame.u) || !is_unit(frame.v) || !(std::fabs(math::dot(frame.u, frame.v)) < 1e-12))
    return std::string("the axes u and v must be perpendicular and have length 1");
  if (!(math::norm(frame.origin_m) <= k_coordinate_m_max))
    return fmt::format("the origin must be at most {} m from the world's origin",
                       k_coordinate_m_max);
  if (rectangles.size() > k_rectangles_max) {
    return fmt::format("{} friction rectangles exceed the maximum of {}", rectangles.size(),
                       k_rectangles_max);
  }
  for (std::size_t i = 0; i < rectangles.size(); ++i) {
    const FrictionRectangle& one = rectangles[i];
    if (!is_interval(one.u_min_m, one.u_max_m) || !is_interval(one.v_min_m, one.v_max_m)) {
      return fmt::format(
          "friction rectangle {}: u from {} to {} m, v from {} to {} m; each upper bound must "
          "exceed its lower bound, and both must be within {} m of 0",
          i, one.u_min_m, one.u_max_m, one.v_min_m, one.v_max_m, k_coordinate_m_max);
    }
    if (!(one.friction >= 0 && one.friction <= k_friction_max)) {
      return fmt::format("friction rectangle {}: friction is {}, expected 0 to {}", i, one.friction,
                         k_friction_max);
    }
  }
  return FrictionMap(frame, std::move(rectangles));
}

FrictionMap::FrictionMap(const MapFrame& frame, std::vector<FrictionRectangle> rectangles)
    : frame_(frame), rectangles_(std::move(rectangles)) {
  std::vector<Box> boxes;
  boxes.reserve(rectangles_.size());
  for (const FrictionRectangle& one : rectangles_)
    boxes.push_back(box_of({one.u_min_m, one.u_max_m}, {one.v_min_m, one.v_max_m}));
  tree_ = BoxTree(boxes);
}

FrictionMap::Plane2 FrictionMap::coordinates(const Vec3& vector) const {
  return {math::dot(frame_.u, vector), math::dot(frame_.v, vector)};
}

std::size_t FrictionMap::count_at(const Plane2& place) const {
  std::size_t last = 0;
  tree_.for_each_overlap(box_of({place.u, place.u}, {place.v, place.v}), [&](std::uint32_t index) {
    const FrictionRectangle& one = rectangles_[index];
    if (holds(one.u_min_m, one.u_max_m, place.u) && holds(one.v_min_m, one.v_max_m, place.v))
      last = std::max(last, std::size_t{index} + 1);
  });
  return last;
}

std::optional<double> FrictionMap::friction_at(const Vec3& point_m) const {
  const std::size_t count = count_at(coordinates(point_m - frame_.origin_m));
  if (count == 0) return std::nullopt;
  return rectangles_[count - 1].friction;
}

double FrictionMap::border_s(const MapPath& path, double most_s) const {
  const Plane2 place = coordinates(path.place_m - frame_.origin_m);
  const Plane2 rate = coordinates(path.velocity_mps);
  const Plane2 bend = coordinates(path.acceleration_mps2);
  const Line u{place.u, rate.u, bend.u};
  const Line v{place.v, rate.v, bend.v};
  const std::size_t here = count_at(place);
  double first_s = most_s;
  if (here > 0) {
    const FrictionRectangle& own = rectangles_[here - 1];
    first_s = std::min(
        {first_s, leaves_s(u, own.u_min_m, own.u_max_m), leaves_s(v, own.v_min_m, own.v_max_m)});
  }
  const Box way = box_of(range_of(u, first_s), range_of(v, first_s));
  tree_.for_each_overlap(way, [&](std::uint32_t index) {
    if (index >= here) first_s = std::min(first_s, enters_s(u, v, rectangles_[index], first_s));
  });
  return first_s;
}

bool FrictionMap::same_as(const FrictionMap& other) const {
  return frame_.origin_m == other.frame_.origin_m && frame_.u == other.frame_.u &&
         frame_.v == other.frame_.v && rectangles_ == other.rectangles_;
}

}  // namespace sleight::physics
