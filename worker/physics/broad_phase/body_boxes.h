// Stores the bodies' boxes, both as floats and as integer codes (periodic.h). Used by every broad
// phase.
//
// Invariant: coded(b) is the code of box(b) for every present b. A broad phase may store its own
// data in a code's fourth numbers: `set` doesn't change them. Thread safety: none.
#pragma once

#include <span>
#include <vector>

#include "worker/physics/broad_phase/broad_phase.h"
#include "worker/physics/broad_phase/periodic.h"

namespace sleight::physics {

class BodyBoxes {
 public:
  explicit BodyBoxes(const BroadPhaseOptions& options)
      : periods_(options.period_m),
        boxes_(options.bodies),
        coded_(options.bodies),
        present_(options.bodies, 0) {
    CHECK_LE(options.bodies, k_bodies_max);
    CHECK(options.size_m > 0);
  }

  const Periods& periods() const { return periods_; }
  std::uint32_t bodies() const { return static_cast<std::uint32_t>(boxes_.size()); }
  bool contains(BodyId body) const { return present_[body] != 0; }
  const Box& box(BodyId body) const { return boxes_[body]; }
  const CodedBox& coded(BodyId body) const { return coded_[body]; }
  CodedBox& coded(BodyId body) { return coded_[body]; }
  std::span<const CodedBox> all_coded() const { return coded_; }

  void check_present(BodyId body) const {
    CHECK_LT(body.value, bodies());
    CHECK(contains(body));
  }
  void check_absent(BodyId body) const {
    CHECK_LT(body.value, bodies());
    CHECK(!contains(body));
  }

  void fetch(BodyId body) const {
    __builtin_prefetch(&coded_[body]);
    __builtin_prefetch(&boxes_[body]);
  }
  void add(BodyId body) { present_[body] = 1; }
  void take_away(BodyId body) { present_[body] = 0; }
  void set(BodyId body, const Box& box, const CodedBox& code) {
    boxes_[body] = box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      coded_[body].start[axis] = code.start[axis];
      coded_[body].width[axis] = code.width[axis];
    }
  }

 private:
  Periods periods_;
  std::vector<Box> boxes_;
  std::vector<CodedBox> coded_;
  std::vector<std::uint8_t> present_;
};

}  // namespace sleight::physics
