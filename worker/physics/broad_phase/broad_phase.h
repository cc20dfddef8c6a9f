// Broad phase: which bodies' boxes overlap, told as changes.
//
// Idea. A simulator watches only pairs of bodies whose temporal bounding volumes overlap (thesis
// 3.2.1). A broad phase keeps the boxes; each change of one tells a sink which overlaps begin and
// which end. The simulator keeps the lists of neighbours, which it needs anyway, and lends them to
// structures that don't remember their pairs.
//
// The simulator uses HierarchicalGrid, a hash of cells for each size of box. Tests compare it with
// others (tests/engines).
//
// Invariants
//   1. At every moment the pairs that have begun and not ended are those of present bodies whose
//      boxes overlap by periodic.h. So all structures tell of the same pairs at the same calls.
//   2. Each call tells of each pair at most once, so an overlap that goes on is never told.
//   3. The order of what a call tells is a function of the calls so far. It differs between
//      structures, so results must not hang on it.
//   4. No allocation once lists have grown to what the scene needs.
// A sink does not call the broad phase from begin or end.
// Thread safety: none; one structure belongs to one simulation.
#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <span>

#include "worker/physics/broad_phase/box.h"
#include "worker/physics/event/event.h"

namespace sleight::physics {

struct BroadPhaseOptions {
  std::uint32_t bodies = 0;          ///< ids are 0 to bodies - 1; at most k_bodies_max
  std::array<double, 3> period_m{};  ///< per axis; 0 for one that does not repeat
  /// Longest edge of the boxes that are most common; sets speed only, never what is told. > 0
  double size_m = 1;
};

/// Pairs of a body and an end of its box fit 29 bits, which sorted lists of ends need
/// (tests/engines/extent_ring.h).
inline constexpr std::uint32_t k_bodies_max = std::uint32_t{1} << 28;

/// What a change of one body's box is told to. `neighbours()` are those whose boxes overlap the
/// body's: before the call those told so far; valid until the next begin or end.
template <class T>
concept OverlapSink = requires(T& sink, BodyId other) {
  sink.begin(other);
  sink.end(other);
  { sink.neighbours() } -> std::convertible_to<std::span<const BodyId>>;
};

/// What a change of all boxes is told to; of each pair the lower id comes first.
template <class T>
concept PairSink = requires(T& sink, BodyId lower, BodyId higher) {
  sink.begin(lower, higher);
  sink.end(lower, higher);
  { sink.neighbours(lower) } -> std::convertible_to<std::span<const BodyId>>;
};

/// Stand-ins with which conformance is checked.
struct NoOverlapSink {
  void begin(BodyId) {}
  void end(BodyId) {}
  static std::span<const BodyId> neighbours() { return {}; }
};
struct NoPairSink {
  void begin(BodyId, BodyId) {}
  void end(BodyId, BodyId) {}
  static std::span<const BodyId> neighbours(BodyId) { return {}; }
};
static_assert(OverlapSink<NoOverlapSink> && PairSink<NoPairSink>);

/// insert    REQUIRES: the body is absent. Tells begin of each overlap.
/// move      REQUIRES: it is present. Replaces its box; tells what begins and ends.
/// remove    REQUIRES: it is present. Tells the end of each overlap.
/// move_all  replaces the boxes of all present bodies at once, as a synchronous simulator does
///           (thesis, Algorithm 3.4); REQUIRES one box per id, absent bodies' are not read.
/// box       as last given. REQUIRES: present.
/// Boxes have low <= high; they may be points, and may be infinite.
template <class T>
concept BroadPhase = std::constructible_from<T, const BroadPhaseOptions&> &&
    requires(T& structure, const T& constant, BodyId body, const Box& box,
             std::span<const Box> boxes, NoOverlapSink& sink, NoPairSink& pairs) {
  structure.insert(body, box, sink);
  structure.move(body, box, sink);
  structure.remove(body, sink);
  structure.move_all(boxes, pairs);
  { constant.box(body) } -> std::same_as<const Box&>;
  { constant.contains(body) } -> std::same_as<bool>;
};

}  // namespace sleight::physics
