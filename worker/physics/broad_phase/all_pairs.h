// The slow reference: every change compares the body's old and new box with everybody's.
//
// A change costs one pass over all boxes, 32 bytes each, in order.
// Invariants and thread safety: broad_phase.h.
#pragma once

#include "worker/physics/broad_phase/body_boxes.h"

namespace sleight::physics {

class AllPairs {
 public:
  explicit AllPairs(const BroadPhaseOptions& options) : boxes_(options), before_(options.bodies) {}

  const Box& box(BodyId body) const { return boxes_.box(body.value); }
  bool contains(BodyId body) const { return boxes_.contains(body.value); }

  template <OverlapSink Sink>
  void insert(BodyId body, const Box& box, Sink& sink) {
    boxes_.check_absent(body);
    const CodedBox code = boxes_.periods().coded(box);
    for_each_other(body.value, [&](std::uint32_t other) {
      if (overlap(code, boxes_.coded(other))) sink.begin(BodyId{other});
    });
    boxes_.add(body.value);
    boxes_.set(body.value, box, code);
  }

  template <OverlapSink Sink>
  void move(BodyId body, const Box& box, Sink& sink) {
    boxes_.check_present(body);
    const CodedBox before = boxes_.coded(body.value);
    const CodedBox after = boxes_.periods().coded(box);
    for_each_other(body.value, [&](std::uint32_t other) {
      const bool was = overlap(before, boxes_.coded(other));
      const bool is = overlap(after, boxes_.coded(other));
      if (is == was) return;
      is ? sink.begin(BodyId{other}) : sink.end(BodyId{other});
    });
    boxes_.set(body.value, box, after);
  }

  template <OverlapSink Sink>
  void remove(BodyId body, Sink& sink) {
    boxes_.check_present(body);
    boxes_.take_away(body.value);
    for_each_other(body.value, [&](std::uint32_t other) {
      if (overlap(boxes_.coded(body.value), boxes_.coded(other))) sink.end(BodyId{other});
    });
  }

  template <PairSink Sink>
  void move_all(std::span<const Box> boxes, Sink& sink) {
    CHECK_EQ(boxes.size(), before_.size());
    for (std::uint32_t body = 0; body < boxes_.bodies(); ++body) {
      before_[body] = boxes_.coded(body);
      if (boxes_.contains(body)) boxes_.set(body, boxes[body], boxes_.periods().coded(boxes[body]));
    }
    for (std::uint32_t lower = 0; lower < boxes_.bodies(); ++lower) {
      if (!boxes_.contains(lower)) continue;
      for (std::uint32_t higher = lower + 1; higher < boxes_.bodies(); ++higher) {
        if (!boxes_.contains(higher)) continue;
        const bool was = overlap(before_[lower], before_[higher]);
        const bool is = overlap(boxes_.coded(lower), boxes_.coded(higher));
        if (is == was) continue;
        is ? sink.begin(BodyId{lower}, BodyId{higher}) : sink.end(BodyId{lower}, BodyId{higher});
      }
    }
  }

 private:
  template <class Visit>
  void for_each_other(std::uint32_t body, const Visit& visit) {
    for (std::uint32_t other = 0; other < boxes_.bodies(); ++other) {
      if (other != body && boxes_.contains(other)) visit(other);
    }
  }

  BodyBoxes boxes_;
  std::vector<CodedBox> before_;  ///< what move_all replaces
};

static_assert(BroadPhase<AllPairs>);

}  // namespace sleight::physics
