#include "clients/export/keys.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "common/base/check.h"
#include "common/math/elementary.h"

namespace sleight::gltf {
namespace {

using math::Quat;
using math::Vec3;
using motion::Segment;

/// Maximum of the factor 1 + |w| d in the bound of |phi''| (keys.h). |w| d is at most k_turn_rad.
constexpr double k_bend = 1 + k_turn_rad;

/// A segment with the time in which it is in effect.
struct Piece {
  Segment segment;
  double from_s = 0;
  double to_s = 0;

  double duration_s() const { return to_s - from_s; }
};

bool moves(const Segment& s) {
  return s.mode != motion::Mode::resting &&
         (s.velocity_mps != Vec3::Zero() || s.acceleration_mps2 != Vec3::Zero() ||
          s.angular_velocity_radps != Vec3::Zero() ||
          s.angular_acceleration_radps2 != Vec3::Zero());
}

/// Returns the segments that end after time 0 and take time, and always the last segment.
std::vector<Piece> pieces_of(const motion::Path& path, double end_s) {
  std::vector<Piece> pieces;
  const auto segments = path.segments();
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const bool is_last = i + 1 == segments.size();
    const double from_s = std::max(0.0, segments[i].start_s);
    double to_s = is_last ? from_s : segments[i + 1].start_s;
    if (is_last && moves(segments[i])) to_s = std::max(from_s, end_s);
    if (is_last || to_s > from_s)
      pieces.push_back({.segment = segments[i], .from_s = from_s, .to_s = to_s});
  }
  return pieces;
}

double angle_between(const Quat& a, const Quat& b) {
  const Quat turn = math::composed(b, math::inverse(a));
  return 2 * math::asin(std::min(1.0, math::norm(Vec3(turn.x(), turn.y(), turn.z()))));
}

Float4 opposite(const Float4& q) {
  return {-q[0], -q[1], -q[2], -q[3]};
}

/// Collects the keys of a channel, in strictly ascending order of rounded times.
template <class Value>
class Keys {
 public:
  /// Adds a key, or replaces the previous one if the rounded times are equal.
  void add(float time_s, const Value& value) {
    if (!channel.times_s.empty() && time_s <= channel.times_s.back()) {
      channel.values.back() = value;
    } else {
      channel.times_s.push_back(time_s);
      channel.values.push_back(value);
    }
  }

  void jump(float time_s, const Value& before, const Value& after) {
    add(time_s, before);
    const float next_s =
        std::nextafter(channel.times_s.back(), std::numeric_limits<float>::infinity());
    add(next_s, after);
  }

  Channel<Value> channel{};
};

/// Chooses q or -q, whichever is nearer to the previous quaternion; both are the same rotation.
void make_neighbours(std::vector<Float4>& rotations) {
  for (std::size_t i = 1; i < rotations.size(); ++i) {
    float along = 0;
    for (std::size_t k = 0; k < 4; ++k)
      along += rotations[i - 1][k] * rotations[i][k];
    if (along < 0) rotations[i] = opposite(rotations[i]);
  }
}

/// Returns the number of equal parts into which a piece is cut.
double parts_for_places(const Piece& piece) {
  return std::max(1.0, std::ceil(std::sqrt(bow_m(piece.segment, piece.duration_s()) / k_bow_m)));
}

double parts_for_turns(const Piece& piece) {
  const Segment& segment = piece.segment;
  if (segment.mode == motion::Mode::resting) return 1;
  const Vec3& a = segment.angular_acceleration_radps2;
  const auto speed_at = [&](double t_s) {
    return math::norm(segment.angular_velocity_radps + (t_s - segment.start_s) * a);
  };
  const double d = piece.duration_s();
  // The speed is convex in time, so its maximum is at an end.
  const double by_turn = d * std::max(speed_at(piece.from_s), speed_at(piece.to_s)) / k_turn_rad;
  const double by_bend = d * std::sqrt(k_bend * math::norm(a) / (8 * k_turn_off_rad));
  return std::max(1.0, std::ceil(std::max(by_turn, by_bend)));
}

template <class Value, class At, class Wide, class Written>
void add_pieces(const std::vector<Piece>& pieces, const std::vector<double>& parts, At at,
                const Wide& is_jump, const Written& written, Keys<Value>& keys) {
  auto value = at(pieces.front(), pieces.front().from_s);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Piece& piece = pieces[i];
    // Add the event that begins the piece.
    const auto begin = at(piece, piece.from_s);
    const auto begin_s = static_cast<float>(piece.from_s);
    if (i > 0 && is_jump(value, begin)) {
      keys.jump(begin_s, written(value), written(begin));
    } else {
      keys.add(begin_s, written(begin));
    }
    // Add the keys in between, each at its rounded time.
    for (double part = 1; part < parts[i]; ++part) {
      const auto time_s = static_cast<float>(piece.from_s + piece.duration_s() * (part / parts[i]));
      if (time_s > begin_s && time_s < piece.to_s) keys.add(time_s, written(at(piece, time_s)));
    }
    value = at(piece, piece.to_s);
  }
  if (pieces.back().duration_s() > 0)
    keys.add(static_cast<float>(pieces.back().to_s), written(value));
}

std::string too_many(double keys) {
  return fmt::format(
      "has too much motion to export: a body needs {:.3g} keys, above the maximum of {}", keys,
      k_keys_max);
}

/// Computes a piece's orientations in the order of time, each from the previous one. Starting from
/// the beginning would repeat all earlier steps each time.
class Turning {
 public:
  Quat operator()(const Piece& piece, double t_s) {
    if (!known_ || piece_from_s_ != piece.from_s) {
      known_ = piece.segment;
      piece_from_s_ = piece.from_s;
    }
    known_->orientation = orientation_at(*known_, t_s);
    known_->angular_velocity_radps += (t_s - known_->start_s) * known_->angular_acceleration_radps2;
    known_->start_s = t_s;
    return known_->orientation;
  }

 private:
  std::optional<Segment> known_;  ///< the segment, as if it had begun at the last requested time
  double piece_from_s_ = 0;
};

base::Result<BodyKeys, std::string> at_frames(const std::vector<Piece>& pieces, double fps) {
  const double from_s = pieces.front().from_s;
  const double first = std::ceil(from_s * fps);
  const double last = std::max(first, std::ceil(pieces.back().to_s * fps));
  if (!(last - first < static_cast<double>(k_keys_max))) return too_many(last - first);
  BodyKeys keys{.enters_s = static_cast<float>(first / fps)};
  Keys<Float3> places;
  Keys<Float4> turns;
  Turning turning;
  std::size_t i = 0;
  for (double frame = first; frame <= last; ++frame) {
    // A rounded product divided by fps may give a moment before from_s.
    const double t_s = std::max(frame / fps, from_s);
    while (i + 1 < pieces.size() && pieces[i + 1].from_s <= t_s)
      ++i;
    const auto time_s = static_cast<float>(frame / fps);
    places.add(time_s, y_up(position_at(pieces[i].segment, t_s)));
    turns.add(time_s, y_up(turning(pieces[i], t_s)));
  }
  keys.translation = std::move(places.channel);
  keys.rotation = std::move(turns.channel);
  return keys;
}

}  // namespace

base::Result<BodyKeys, std::string> keys_of(const motion::Path& path, double end_s,
                                            std::optional<double> fps) {
  CHECK(path.enters());
  const std::vector<Piece> pieces = pieces_of(path, end_s);

  // Count the keys before making any, even if `fps` is set, since this also bounds the amount of
  // rotation.
  std::vector<double> for_places;
  std::vector<double> for_turns;
  double total = 0;
  for (const Piece& piece : pieces) {
    for_places.push_back(parts_for_places(piece));
    for_turns.push_back(parts_for_turns(piece));
    total += std::max(for_places.back(), for_turns.back());
  }
  if (!(total <= static_cast<double>(k_keys_max))) return too_many(total);

  BodyKeys keys{.enters_s = static_cast<float>(pieces.front().from_s)};
  if (fps) {
    CHECK(*fps > 0 && *fps <= k_fps_max);
    auto framed = at_frames(pieces, *fps);
    if (!framed) return framed.error();
    keys = std::move(framed).value();
    make_neighbours(keys.rotation.values);
    return keys;
  }

  Keys<Float3> places;
  add_pieces(
      pieces, for_places,
      [](const Piece& piece, double t_s) { return Vec3(position_at(piece.segment, t_s)); },
      [](const Vec3& a, const Vec3& b) { return math::norm(b - a) > k_jump_m; },
      [](const Vec3& place) { return y_up(place); }, places);
  Keys<Float4> turns;
  add_pieces(
      pieces, for_turns, Turning(),
      [](const Quat& a, const Quat& b) { return angle_between(a, b) > k_jump_rad; },
      [](const Quat& turn) { return y_up(turn); }, turns);
  keys.translation = std::move(places.channel);
  keys.rotation = std::move(turns.channel);
  make_neighbours(keys.rotation.values);
  return keys;
}

}  // namespace sleight::gltf
