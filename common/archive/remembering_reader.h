// A reader that caches motions, so that each is simulated only once. An archive's writer requests
// each kept animation's motion twice, to select the animation and to write it. The run's next
// archive requests the motion once more.
//
// The cache does not change an archive's content. Not thread-safe: all motions share one cache.
#pragma once

#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "common/archive/forwarding_reader.h"

namespace sleight::archive {

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
