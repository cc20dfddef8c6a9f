// Broad phase: reports which bodies' boxes begin or stop overlapping.
//
// Idea. A simulator watches only pairs of bodies whose temporal bounding volumes overlap (thesis
// 3.2.1). A broad phase stores the boxes, and at each change of a box reports to a sink which
// overlaps begin and end. The simulator stores the lists of neighbours, which it needs anyway, and
// lends them to structures that don't store their pairs.
//
// The simulator uses HierarchicalGrid, a hash of cells per box size. Tests compare other structures
// with it (tests/engines).
//
// Invariants
//   1. At every moment, the pairs that have begun and not ended are the pairs of present bodies
//      whose boxes overlap by periodic.h. So all structures report the same pairs at the same
//      calls.
//   2. Each call reports each pair at most once, so a continuing overlap is never reported.
//   3. The order of a call's reports depends only on the calls so far. The order differs between
//      structures, so results must not depend on it.
//   4. No allocation once lists have grown to the scene's needs.
// A sink does not call the broad phase from begin or end. Thread safety: none; one structure
// belongs to one simulation.
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
  std::array<double, 3> period_m{};  ///< per axis; 0: the axis does not repeat
  /// Longest edge of the most common boxes, > 0. Affects speed only, never reports.
  double size_m = 1;
};

/// A body and an end of its box together fit 29 bits, which sorted lists of ends need
/// (tests/engines/extent_ring.h).
inline constexpr std::uint32_t k_bodies_max = std::uint32_t{1} << 28;

/// Receives the reports about one body. `neighbours()` returns the bodies that overlap this body,
/// as reported before the call; valid until the next begin or end.
template <class T>
concept OverlapSink = requires(T& sink, BodyId other) {
  sink.begin(other);
  sink.end(other);
  { sink.neighbours() } -> std::convertible_to<std::span<const BodyId>>;
};

/// Receives the reports about all bodies. Each pair's lower id comes first.
template <class T>
concept PairSink = requires(T& sink, BodyId lower, BodyId higher) {
  sink.begin(lower, higher);
  sink.end(lower, higher);
  { sink.neighbours(lower) } -> std::convertible_to<std::span<const BodyId>>;
};

/// Sinks for checking conformance.
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

/// insert    REQUIRES: the body is absent. Reports the begin of each overlap.
/// move      REQUIRES: the body is present. Replaces its box; reports what begins and ends.
/// remove    REQUIRES: the body is present. Reports the end of each overlap.
/// move_all  Replaces the boxes of all present bodies at once, like a synchronous simulator
///           (thesis, Algorithm 3.4). REQUIRES one box per id; boxes of absent bodies aren't read.
/// box       Returns the last given box. REQUIRES: the body is present.
/// Boxes have low <= high. Boxes may be points, and may be infinite.
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
