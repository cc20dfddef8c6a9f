#include "worker/worlds/segments/recorded_segments.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/check.h"
#include "worker/physics/motion/rotation_bounds.h"
#include "worker/physics/motion/rotation_track.h"

namespace sleight::worlds {
namespace {

motion::Mode mode_of(physics::MotionMode mode) {
  constexpr std::array k_modes{motion::Mode::flying, motion::Mode::sliding, motion::Mode::rolling,
                               motion::Mode::resting};
  return k_modes.at(static_cast<std::size_t>(mode));
}

/// Sets the cause, unless it is the start, and the partner of a hit.
void set_cause(motion::Segment& segment, const physics::EventKey& event, std::uint32_t body,
               std::span<const RecordedBody> bodies, const FixedFeature& fixed) {
  switch (event.kind) {
    case physics::EventKind::start:
      return;
    case physics::EventKind::mode:
      segment.cause = motion::Cause::mode;
      return;
    case physics::EventKind::collision:
      if (event.lower == body || event.higher == body) {
        const std::uint32_t other = event.lower == body ? event.higher : event.lower;
        segment.cause = motion::Cause::hit;
        segment.partner = (other & physics::k_static) != 0
                              ? fixed(body, other & ~physics::k_static)
                              : static_cast<std::int32_t>(bodies[other].feature);
        return;
      }
      // A collision of other bodies removed the body's support.
      [[fallthrough]];
    case physics::EventKind::rest:
      segment.cause = motion::Cause::rest;
      return;
    default:
      base::check_failed("the event begins a segment", "");
  }
}

/// A segment is divided into cells, and a piece consists of cells. A body turns by so little in a
/// cell that a piece of one cell needs no test.
constexpr double k_cell_rad = 1.0 / 32;
constexpr double k_cells_max = 1 << 20;        ///< limits memory if a body turns unreasonably fast
constexpr std::size_t k_piece_cells_max = 64;  ///< 2 rad; turns beyond pi would be ambiguous
constexpr std::size_t k_tests = 6;             ///< instants of a piece that are examined
/// At these instants, deviations may reach this share of the tolerances, because the greatest
/// deviation is between the instants.
constexpr double k_tested_off = 0.9;
/// A piece's accelerations are corrected if its end deviates by more than this share of the
/// tolerances. Smaller corrections would be rounding errors, divided by the square of a short time.
constexpr double k_end_off = 0.01;
constexpr int k_corrections = 3;

/// Returns the rotation vector from one orientation to another, if the angle is small. Otherwise,
/// the result is large too.
math::Vec3 small_turn_rad(const math::Quat& from, const math::Quat& to) {
  const math::Quat turn = math::composed(to, math::inverse(from));
  return math::Vec3(turn.x(), turn.y(), turn.z()) * (turn.w() < 0 ? -2 : 2);
}

/// Converts one recorded segment.
class Cutter {
 public:
  Cutter(const RecordedBody& body, const physics::Segment& segment, physics::Tick end)
      : body_(body),
        segment_(segment),
        is_free_(segment.mode == physics::MotionMode::free),
        is_centred_(physics::is_zero(body.frame.position_m)),
        begin_(segment.flight.begin),
        end_(std::max(begin_, end)),
        span_s_(physics::seconds(end_ - begin_)) {
    CHECK(is_centred_ || body.reach_m > 0);
  }

  /// Appends the pieces. `first` contains the body, mode, cause and partner.
  void append_to(std::vector<motion::Segment>& segments, motion::Segment first) {
    first.acceleration_mps2 = segment_.flight.acceleration_mps2;
    first.angular_acceleration_radps2 = segment_.angular_acceleration_radps2;
    const motion::Segment begin = shown_at(begin_, first);
    if (is_exact()) return segments.push_back(begin);
    if (is_free_) track_.restart(segment_.flight, body_.inertia);
    first.cause = motion::Cause::mode;
    first.partner = motion::k_no_partner;
    const physics::TickCount cells = cell_count();
    const physics::TickCount cell = (end_ - begin_) / cells;
    // The states at the cells' ends, from the start of the piece on.
    std::vector<motion::Segment> states{begin};
    for (physics::TickCount made = 0; made < cells || states.size() > 1;) {
      for (; made < cells && states.size() <= k_piece_cells_max; ++made)
        states.push_back(shown_at(made + 1 < cells ? begin_ + (made + 1) * cell : end_, first));
      // Shorten the piece by an eighth until it is accurate.
      std::size_t last = states.size() - 1;
      while (!join(std::span(states).first(last + 1)))
        last -= std::max<std::size_t>(1, last / 8);
      segments.push_back(states.front());
      states.erase(states.begin(), states.begin() + static_cast<std::ptrdiff_t>(last));
    }
  }

 private:
  /// Returns whether the segment is a segment of common/motion as it is.
  bool is_exact() const {
    if (segment_.mode == physics::MotionMode::resting || begin_ == end_) return true;
    if (!is_centred_) return false;
    if (!is_free_ || body_.inertia.symmetry == physics::InertiaSymmetry::spherical) return true;
    // If the axis of a spinning body hardly turns, the error is at most a s^2 / 2.
    const physics::RotationBounds bounds = physics::rotation_bounds(segment_.flight, body_.inertia);
    return 0.5 * bounds.angular_acceleration_radps2 * span_s_ * span_s_ <= k_turn_off_rad;
  }

  physics::TickCount cell_count() const {
    const math::Vec3& w = segment_.flight.angular_velocity_radps;
    const double speed_radps =
        is_free_ ? physics::rotation_bounds(segment_.flight, body_.inertia).angular_speed_radps
                 : std::max(math::norm(w),
                            math::norm(w + span_s_ * segment_.angular_acceleration_radps2));
    // If the shown origin is far outside the body, its path needs shorter cells.
    const double lever =
        is_centred_ ? 1 : std::max(1.0, math::norm(body_.frame.position_m) / body_.reach_m);
    const double cells = std::min(speed_radps * span_s_ * lever / k_cell_rad + 1, k_cells_max);
    return std::min(end_ - begin_, static_cast<physics::TickCount>(cells));
  }

  /// Returns `like` with the shown frame's state at a tick.
  motion::Segment shown_at(physics::Tick tick, motion::Segment like) {
    const physics::FreeFlight& flight = segment_.flight;
    physics::Pose pose{.position_m = flight.position_m, .orientation = flight.orientation};
    physics::Twist twist = physics::twist_at_begin(segment_);
    if (tick > begin_ && is_free_) {
      pose = physics::pose_at(flight, track_, tick);
      twist = physics::twist_at(flight, track_, tick);
    } else if (tick > begin_) {
      pose = {.position_m = physics::position_at(flight, tick),
              .orientation = physics::orientation_of(segment_, body_.inertia, tick)};
      twist = physics::twist_of(segment_, body_.inertia, tick);
    }
    like.start_s = physics::seconds(tick - physics::Tick{});
    like.position_m = pose.position_m;
    like.velocity_mps = twist.velocity_mps;
    like.orientation = math::composed(pose.orientation, body_.frame.orientation);
    like.angular_velocity_radps = twist.angular_velocity_radps;
    if (is_centred_) return like;
    const math::Vec3 lever_m = math::rotated(pose.orientation, body_.frame.position_m);
    like.position_m += lever_m;
    like.velocity_mps += math::cross(twist.angular_velocity_radps, lever_m);
    return like;
  }

  /// Lets the first state's piece lead to the last one. Returns whether the piece is accurate.
  bool join(std::span<motion::Segment> states) const {
    motion::Segment& piece = states.front();
    const motion::Segment& to = states.back();
    const double h = to.start_s - piece.start_s;
    piece.angular_acceleration_radps2 =
        (to.angular_velocity_radps - piece.angular_velocity_radps) / h;
    for (int i = 0; i < k_corrections; ++i) {
      const math::Vec3 off_rad =
          small_turn_rad(motion::orientation_at(piece, to.start_s), to.orientation);
      if (math::norm(off_rad) <= k_end_off * k_turn_off_rad) break;
      piece.angular_acceleration_radps2 += off_rad * (2 / (h * h));
    }
    if (!is_centred_) {
      piece.acceleration_mps2 = (to.velocity_mps - piece.velocity_mps) / h;
      const math::Vec3 off_m = to.position_m - motion::position_at(piece, to.start_s);
      if (math::norm(off_m) > k_end_off * k_place_off * body_.reach_m)
        piece.acceleration_mps2 += off_m * (2 / (h * h));
    }
    const std::size_t cells = states.size() - 1;
    for (std::size_t test = k_tests; test > 0 && cells > 1; --test)
      if (off(piece, states[cells * test / k_tests]) > k_tested_off) return false;
    return true;
  }

  /// Returns a piece's deviation from a state, as a share of the tolerances.
  double off(const motion::Segment& piece, const motion::Segment& there) const {
    const math::Quat orientation = motion::orientation_at(piece, there.start_s);
    const double off = math::norm(small_turn_rad(orientation, there.orientation)) / k_turn_off_rad;
    if (is_centred_) return off;
    const math::Vec3 off_m = motion::position_at(piece, there.start_s) - there.position_m;
    const math::Vec3 centre_m =  // of mass, in the shown frame
        math::rotated(math::inverse(body_.frame.orientation), math::Vec3(-body_.frame.position_m));
    const math::Vec3 centre_off_m =
        off_m + math::rotated(orientation, centre_m) - math::rotated(there.orientation, centre_m);
    const double place_off = std::max(math::norm(off_m), math::norm(centre_off_m));
    return std::max(off, place_off / (k_place_off * body_.reach_m));
  }

  const RecordedBody& body_;
  const physics::Segment& segment_;
  bool is_free_;
  bool is_centred_;
  physics::Tick begin_;
  physics::Tick end_;
  double span_s_;
  physics::RotationTrack track_;
};

}  // namespace

std::vector<motion::Segment> recorded_segments(const physics::Recording& recording,
                                               std::span<const RecordedBody> bodies,
                                               const FixedFeature& fixed) {
  CHECK_EQ(bodies.size(), recording.bodies());
  std::vector<motion::Segment> segments;
  segments.reserve(recording.segment_count());
  for (std::uint32_t body = 0; body < bodies.size(); ++body) {
    if (!bodies[body].moves) continue;
    const std::span entries = recording.segments(physics::BodyId{body});
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const auto& [segment, event] = entries[i];
      motion::Segment first{.body = bodies[body].feature, .mode = mode_of(segment.mode)};
      set_cause(first, event, body, bodies, fixed);
      const physics::Tick end =
          i + 1 < entries.size() ? entries[i + 1].segment.flight.begin : recording.end();
      Cutter(bodies[body], segment, end).append_to(segments, first);
    }
  }
  return segments;
}

}  // namespace sleight::worlds
