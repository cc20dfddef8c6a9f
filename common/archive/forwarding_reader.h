// A reader that forwards all calls to another reader. Base of readers that change some calls.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/archive/world_layout.h"

namespace sleight::archive {

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

}  // namespace sleight::archive
