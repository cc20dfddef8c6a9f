#include "worker/worlds/segments/recorded_segments.h"

#include "common/base/check.h"

namespace sleight::worlds {
namespace {

motion::Mode mode_of(physics::MotionMode mode) {
  switch (mode) {
    case physics::MotionMode::free:
      return motion::Mode::flying;
    case physics::MotionMode::sliding:
      return motion::Mode::sliding;
    case physics::MotionMode::rolling:
      return motion::Mode::rolling;
    case physics::MotionMode::resting:
      return motion::Mode::resting;
  }
  base::check_failed("the mode is known", "");
}

/// Why a segment begins. If a hit is the cause, `partner` is set.
struct Beginning {
  motion::Cause cause = motion::Cause::start;
  std::int32_t partner = motion::k_no_partner;
};

Beginning beginning_of(const physics::EventKey& event, std::uint32_t body,
                       std::span<const RecordedBody> bodies, const FixedFeature& fixed) {
  switch (event.kind) {
    case physics::EventKind::start:
      return {.cause = motion::Cause::start};
    case physics::EventKind::mode:
      return {.cause = motion::Cause::mode};
    case physics::EventKind::rest:
      return {.cause = motion::Cause::rest};
    case physics::EventKind::collision: {
      const bool is_fixed = (event.higher & physics::k_static) != 0;
      if (is_fixed && event.lower == body)
        return {.cause = motion::Cause::hit, .partner = fixed(event.higher & ~physics::k_static)};
      if (!is_fixed && (event.lower == body || event.higher == body)) {
        const std::uint32_t other = event.lower == body ? event.higher : event.lower;
        return {.cause = motion::Cause::hit,
                .partner = static_cast<std::int32_t>(bodies[other].feature)};
      }
      // A collision of other bodies removed the body's support.
      return {.cause = motion::Cause::rest};
    }
    default:
      break;
  }
  base::check_failed("the event begins a segment", "");
}

}  // namespace

std::vector<motion::Segment> recorded_segments(const physics::Recording& recording,
                                               std::span<const RecordedBody> bodies,
                                               const FixedFeature& fixed) {
  CHECK_EQ(bodies.size(), recording.bodies());
  std::vector<motion::Segment> segments;
  segments.reserve(recording.segment_count());
  for (std::uint32_t body = 0; body < bodies.size(); ++body) {
    for (const auto& [segment, event] : recording.segments(physics::BodyId{body})) {
      const physics::FreeFlight& flight = segment.flight;
      const Beginning beginning = beginning_of(event, body, bodies, fixed);
      segments.push_back({.body = bodies[body].feature,
                          .start_s = physics::seconds(flight.begin - physics::Tick{}),
                          .mode = mode_of(segment.mode),
                          .cause = beginning.cause,
                          .partner = beginning.partner,
                          .position_m = flight.position_m,
                          .velocity_mps = flight.velocity_mps,
                          .acceleration_mps2 = flight.acceleration_mps2,
                          .orientation = math::composed(flight.orientation, bodies[body].turn),
                          .angular_velocity_radps = flight.angular_velocity_radps,
                          .angular_acceleration_radps2 = segment.angular_acceleration_radps2});
    }
  }
  return segments;
}

}  // namespace sleight::worlds
