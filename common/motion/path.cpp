#include "common/motion/path.h"

#include <algorithm>
#include <cmath>
#include <concepts>

#include <fmt/format.h>

#include "common/motion/fields.h"

namespace sleight::motion {
namespace {

/// A quaternion is a rotation if its squared norm differs from 1 by at most this.
constexpr double k_norm_off_max = 1e-3;

bool is_sane(const Segment& segment) {
  bool is_sane = true;
  for_each_field(k_fields, [&]<class Value>(const Field<Segment, Value>& field) {
    if constexpr (std::same_as<Element<Value>, double>) {
      // False for NaN.
      for (const double element : elements_of(segment.*field.member))
        is_sane = is_sane && std::abs(element) <= k_number_max;
    }
  });
  return is_sane;
}

bool is_rotation(const math::Quat& q) {
  const double square = q.w() * q.w() + q.x() * q.x() + q.y() * q.y() + q.z() * q.z();
  return std::abs(square - 1) <= k_norm_off_max;
}

}  // namespace

const Segment* Path::segment_at(double t_s) const {
  const auto after = std::upper_bound(segments_.begin(), segments_.end(), t_s,
                                      [](double t, const Segment& s) { return t < s.start_s; });
  return after == segments_.begin() ? nullptr : &*std::prev(after);
}

std::optional<Pose> Path::pose_at(double t_s) const {
  const Segment* segment = segment_at(t_s);
  if (segment == nullptr) return std::nullopt;
  return Pose{.centre_m = position_at(*segment, t_s), .orientation = orientation_at(*segment, t_s)};
}

std::optional<math::Vec3> Path::centre_at(double t_s) const {
  const Segment* segment = segment_at(t_s);
  if (segment == nullptr) return std::nullopt;
  return position_at(*segment, t_s);
}

base::Result<Animation, std::string> Animation::of(std::span<const Segment> segments,
                                                   std::size_t bodies) {
  Animation animation;
  for (std::uint32_t body = 0; body < bodies; ++body)
    animation.paths_.emplace_back(body);
  for (const Segment& segment : segments) {
    if (segment.body >= bodies)
      return fmt::format("a segment moves body {}, but the scene has only {} bodies",
                         segment.body + 1, bodies);
    if (!is_rotation(segment.orientation))
      return std::string("a segment's orientation is not a rotation");
    if (!is_sane(segment)) return std::string("a segment has invalid numbers");
    Path& path = animation.paths_[segment.body];
    if (path.enters() && path.rest_s() > segment.start_s)
      return std::string("the segments are out of time order");
    Segment kept = segment;
    kept.orientation = math::normalized(segment.orientation);
    path.append(kept);
    animation.end_s_ = std::max(animation.end_s_, segment.start_s);
  }
  return animation;
}

std::size_t Animation::segment_count() const {
  std::size_t count = 0;
  for (const Path& path : paths_)
    count += path.segments().size();
  return count;
}

}  // namespace sleight::motion
