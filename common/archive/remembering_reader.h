// A reader that caches motions, so that each is simulated only once. An archive's writer requests
// each kept animation's motion twice, to select the animation and to write it. The run's next
// archive requests the motion once more.
//
// The cache does not change an archive's content. Not thread-safe: all motions share one cache.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "common/archive/world_layout.h"

namespace sleight::archive {

/// A reader that forwards all calls to another reader. Base of readers that change some calls.
class ForwardingReader : public StateReader {
 public:
  /// The forwarder borrows `reader`.
  explicit ForwardingReader(const StateReader& reader) : reader_(reader) {}

  const WorldLayout& layout() const override { return reader_.layout(); }
  std::vector<double> variables(base::BytesView state) const override {
    return reader_.variables(state);
  }
  std::vector<double> likeness(base::BytesView state) const override {
    return reader_.likeness(state);
  }
  double likeness_distance(std::span<const double> a, std::span<const double> b) const override {
    return reader_.likeness_distance(a, b);
  }
  bool is_unlike(std::span<const double> a, std::span<const double> b,
                 double distance) const override {
    return reader_.is_unlike(a, b, distance);
  }
  Motion play(base::BytesView state) const override { return reader_.play(state); }
  const scene::Scene& scene() const override { return reader_.scene(); }
  scene::Variation variation(base::BytesView state,
                             std::span<const motion::Segment> segments) const override {
    return reader_.variation(state, segments);
  }
  std::vector<double> prior_draw(std::uint64_t nth) const override {
    return reader_.prior_draw(nth);
  }
  std::vector<double> log_priors_of_throws(std::size_t count) const override {
    return reader_.log_priors_of_throws(count);
  }

 private:
  const StateReader& reader_;
};

/// A cache of motions by state. The cache may drop any motion.
class Motions {
 public:
  virtual ~Motions() = default;
  virtual std::optional<Motion> find(base::BytesView state) = 0;
  virtual void keep(base::BytesView state, const Motion& motion) = 0;
};

class RememberingReader final : public ForwardingReader {
 public:
  /// Calls `before_each` before each simulation of a motion and before each computation of a
  /// likeness. An exception from `before_each` ends the work. All arguments are borrowed.
  RememberingReader(const StateReader& reader, Motions& motions,
                    std::function<void()> before_each = {})
      : ForwardingReader(reader), motions_(motions), before_each_(std::move(before_each)) {}

  std::vector<double> likeness(base::BytesView state) const override {
    if (before_each_) before_each_();
    return ForwardingReader::likeness(state);
  }
  Motion play(base::BytesView state) const override {
    if (auto known = motions_.find(state)) return *std::move(known);
    if (before_each_) before_each_();
    Motion motion = ForwardingReader::play(state);
    motions_.keep(state, motion);
    return motion;
  }

 private:
  Motions& motions_;
  std::function<void()> before_each_;
};

}  // namespace sleight::archive
