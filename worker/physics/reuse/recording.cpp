#include "worker/physics/reuse/recording.h"

#include <algorithm>
#include <cstring>

namespace sleight::physics {
namespace {

/// FNV-1a over whole words.
class Digest {
 public:
  void add(std::uint64_t word) { value_ = (value_ ^ word) * 0x100000001b3U ^ (value_ >> 29U); }
  void add(double number) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &number, sizeof(bits));
    add(bits);
  }
  void add(const Vec3& v) {
    add(v.x());
    add(v.y());
    add(v.z());
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325U;
};

}  // namespace

void Recording::reset(std::size_t bodies, std::size_t segments_reserved) {
  of_body_.assign(bodies, {});
  for (auto& entries : of_body_)
    entries.reserve(segments_reserved);
  end_ = {};
}

void Recording::append(BodyId body, const Segment& segment, const EventKey& cause) {
  of_body_[body.value].push_back({segment, cause});
}

std::size_t Recording::segment_count() const {
  std::size_t count = 0;
  for (const auto& entries : of_body_)
    count += entries.size();
  return count;
}

const Segment* Recording::segment_at(BodyId body, Tick tick) const {
  const auto& entries = of_body_[body.value];
  const auto after =
      std::upper_bound(entries.begin(), entries.end(), tick,
                       [](Tick t, const Entry& entry) { return t < entry.segment.flight.begin; });
  return after == entries.begin() ? nullptr : &std::prev(after)->segment;
}

std::uint64_t Recording::digest() const {
  Digest digest;
  for (const auto& entries : of_body_) {
    digest.add(std::uint64_t{entries.size()});
    for (const Entry& entry : entries) {
      const Segment& s = entry.segment;
      digest.add(static_cast<std::uint64_t>(s.flight.begin.value));
      digest.add(s.flight.position_m);
      digest.add(s.flight.velocity_mps);
      digest.add(s.flight.acceleration_mps2);
      digest.add(s.flight.orientation.w());
      digest.add(
          Vec3(s.flight.orientation.x(), s.flight.orientation.y(), s.flight.orientation.z()));
      digest.add(s.flight.angular_velocity_radps);
      digest.add(s.angular_acceleration_radps2);
      digest.add(static_cast<std::uint64_t>(s.mode));
      digest.add(static_cast<std::uint64_t>(entry.cause.tick.value));
      digest.add(static_cast<std::uint64_t>(entry.cause.kind));
      digest.add((std::uint64_t{entry.cause.lower} << 32U) | entry.cause.higher);
      digest.add(std::uint64_t{entry.cause.feature});
    }
  }
  digest.add(static_cast<std::uint64_t>(end_.value));
  return digest.value();
}

}  // namespace sleight::physics
