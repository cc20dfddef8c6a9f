// A slow broad phase: each change compares the body's old and new box with all other boxes.
//
// A change costs one pass over all boxes in order. A box takes 32 bytes. Invariants and thread
// safety: broad_phase.h.
#pragma once

#include "worker/physics/broad_phase/body_boxes.h"

namespace sleight::physics {

class AllPairs {
 public:
  explicit AllPairs(const BroadPhaseOptions& options) : boxes_(options), before_(options.bodies) {}

  const Box& box(BodyId body) const { return boxes_.box(body); }
  bool contains(BodyId body) const { return boxes_.contains(body); }

  template <OverlapSink Sink>
  void insert(BodyId body, const Box& box, Sink& sink) {
    boxes_.check_absent(body);
    const CodedBox code = boxes_.periods().coded(box);
    for_each_other(body, [&](BodyId other) {
      if (overlap(code, boxes_.coded(other))) sink.begin(other);
    });
    boxes_.add(body);
    boxes_.set(body, box, code);
  }

  template <OverlapSink Sink>
  void move(BodyId body, const Box& box, Sink& sink) {
    boxes_.check_present(body);
    const CodedBox before = boxes_.coded(body);
    const CodedBox after = boxes_.periods().coded(box);
    for_each_other(body, [&](BodyId other) {
      const bool was = overlap(before, boxes_.coded(other));
      const bool is = overlap(after, boxes_.coded(other));
      if (is == was) return;
      is ? sink.begin(other) : sink.end(other);
    });
    boxes_.set(body, box, after);
  }

  template <OverlapSink Sink>
  void remove(BodyId body, Sink& sink) {
    boxes_.check_present(body);
    boxes_.take_away(body);
    for_each_other(body, [&](BodyId other) {
      if (overlap(boxes_.coded(body), boxes_.coded(other))) sink.end(other);
    });
  }

  template <PairSink Sink>
  void move_all(std::span<const Box> boxes, Sink& sink) {
    CHECK_EQ(boxes.size(), before_.size());
    for (BodyId body{}; body < boxes_.bodies(); ++body) {
      before_[body] = boxes_.coded(body);
      if (boxes_.contains(body)) boxes_.set(body, boxes[body], boxes_.periods().coded(boxes[body]));
    }
    for (BodyId lower{}; lower < boxes_.bodies(); ++lower) {
      if (!boxes_.contains(lower)) continue;
      for (BodyId higher{lower + 1}; higher < boxes_.bodies(); ++higher) {
        if (!boxes_.contains(higher)) continue;
        const bool was = overlap(before_[lower], before_[higher]);
        const bool is = overlap(boxes_.coded(lower), boxes_.coded(higher));
        if (is == was) continue;
        is ? sink.begin(lower, higher) : sink.end(lower, higher);
      }
    }
  }

 private:
  template <class Visit>
  void for_each_other(BodyId body, const Visit& visit) {
    for (BodyId other{}; other < boxes_.bodies(); ++other) {
      if (other != body && boxes_.contains(other)) visit(other);
    }
  }

  BodyBoxes boxes_;
  std::vector<CodedBox> before_;  ///< what move_all replaces
};

static_assert(BroadPhase<AllPairs>);

}  // namespace sleight::physics
