// The motion of an animation: for each body, the segments in order of time.
//
// Thread safety: values; const functions may be called from several threads at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/motion/segment.h"

namespace sleight::motion {

struct Pose {
  math::Vec3 centre_m{0, 0, 0};
  math::Quat orientation = math::Quat::Identity();  ///< from the body's frame to the scene's
};

/// One body's motion. A body that never enters the scene has no segment.
class Path {
 public:
  explicit Path(std::uint32_t body = 0) : body_(body) {}
  /// REQUIRES: segments are appended in order of start.
  void append(const Segment& segment) { segments_.push_back(segment); }

  std::uint32_t body() const { return body_; }
  std::span<const Segment> segments() const { return segments_; }
  bool enters() const { return !segments_.empty(); }
  /// REQUIRES: the body enters.
  double start_s() const { return segments_.front().start_s; }
  /// Returns the start of the last segment, when the body comes to rest. REQUIRES: the body enters.
  double rest_s() const { return segments_.back().start_s; }

  /// Returns the segment at a time, or null before the body enters. If several segments start at
  /// that time, returns the last.
  const Segment* segment_at(double t_s) const;
  /// Returns nothing before the body enters. For times after the last start, evaluates the last
  /// segment.
  std::optional<Pose> pose_at(double t_s) const;
  std::optional<math::Vec3> centre_at(double t_s) const;

 private:
  std::uint32_t body_;
  std::vector<Segment> segments_;
};

class Animation {
 public:
  /// Builds an animation from segments. Bodies may be in any order, but each body's segments are in
  /// order of start. The segments may come from an untrusted file. Returns the fault if a body is
  /// unknown, a start is not finite or decreases, a number is beyond k_number_max, or an
  /// orientation is not a rotation. Stored orientations have norm 1.
  static base::Result<Animation, std::string> of(std::span<const Segment> segments,
                                                 std::size_t bodies);

  std::span<const Path> paths() const { return paths_; }
  const Path& path(std::uint32_t body) const { return paths_[body]; }
  std::size_t bodies() const { return paths_.size(); }
  /// Time when the last body came to rest; 0 if no body enters.
  double end_s() const { return end_s_; }
  std::size_t segment_count() const;

 private:
  std::vector<Path> paths_;
  double end_s_ = 0;
};

/// Largest valid number in a segment, in SI units. No simulated motion reaches it.
inline constexpr double k_number_max = 1e9;

}  // namespace sleight::motion
