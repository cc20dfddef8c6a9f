// The motion of a whole animation: of each body its segments, in the order of time.
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

/// One body's motion. A body that never enters has no segment.
class Path {
 public:
  explicit Path(std::uint32_t body = 0) : body_(body) {}
  /// REQUIRES: in the order of starts.
  void append(const Segment& segment) { segments_.push_back(segment); }

  std::uint32_t body() const { return body_; }
  std::span<const Segment> segments() const { return segments_; }
  bool enters() const { return !segments_.empty(); }
  /// REQUIRES: it enters.
  double start_s() const { return segments_.front().start_s; }
  /// When its last segment begins: it rests from then on. REQUIRES: it enters.
  double rest_s() const { return segments_.back().start_s; }

  /// The segment in force, the last if several begin then; null before it enters.
  const Segment* segment_at(double t_s) const;
  /// Nothing before it enters; later than its last start, what that segment says.
  std::optional<Pose> pose_at(double t_s) const;
  std::optional<math::Vec3> centre_at(double t_s) const;

 private:
  std::uint32_t body_;
  std::vector<Segment> segments_;
};

class Animation {
 public:
  /// Of segments in any order of bodies, each body's in the order of starts. What is wrong with
  /// numbers from a file that isn't ours: bodies that the scene doesn't have, starts that go back
  /// or are not finite, numbers beyond k_number_max, orientations that are no rotations. Kept
  /// orientations have norm 1.
  static base::Result<Animation, std::string> of(std::span<const Segment> segments,
                                                 std::size_t bodies);

  /// By body.
  std::span<const Path> paths() const { return paths_; }
  const Path& path(std::uint32_t body) const { return paths_[body]; }
  std::size_t bodies() const { return paths_.size(); }
  /// When the last body came to rest; 0 if none enters.
  double end_s() const { return end_s_; }
  std::size_t segment_count() const;

 private:
  std::vector<Path> paths_;
  double end_s_ = 0;
};

/// Larger numbers, in SI units, are no motion of anything that is simulated here.
inline constexpr double k_number_max = 1e9;

}  // namespace sleight::motion
