// A reader that remembers motions, so that none is simulated twice: an archive asks for each kept
// animation's motion when it chooses and when it writes, and the next archive of the run again.
//
// It changes nothing that an archive says. Not thread-safe: motions go through one memory.
#pragma once

#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "common/archive/forwarding_reader.h"

namespace sleight::archive {

/// Where motions are remembered, by their states. It may forget any of them.
class Motions {
 public:
  virtual ~Motions() = default;
  virtual std::optional<Motion> find(base::BytesView state) = 0;
  virtual void keep(base::BytesView state, const Motion& motion) = 0;
};

class RememberingReader final : public ForwardingReader {
 public:
  /// `before_each` is called before each motion that has to be simulated and before each animation
  /// that is to be compared; what it throws ends the work. Everything is borrowed.
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
