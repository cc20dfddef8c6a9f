// Broad phase: reports which bodies' boxes begin or stop overlapping.
//
// Idea. A simulator watches only pairs of bodies whose temporal bounding volumes overlap (thesis
// 3.2.1). A broad phase stores the boxes, and at each change of a box reports to a sink which
// overlaps begin and end. The simulator needs each body's list of neighbours anyway, so a broad
// phase that stores no pairs reads these lists (`neighbours()`).
//
// The simulator uses HierarchicalGrid, a hash of cells per box size. Tests compare HierarchicalGrid
// with other broad phases (tests/engines).
//
// Invariants
//   1. At every moment, the reported pairs (begun and not ended) are the pairs of present bodies
//      whose boxes overlap (periodic.h). So all broad phases report the same pairs at the same
//      calls.
//   2. Each call reports each pair at most once, so a continuing overlap is never reported.
//   3. The order of a call's reports depends only on the calls so far. The order differs between
//      broad phases, so results must not depend on the order.
//   4. Nothing is allocated once lists have grown to the scene's needs.
// A sink must not call the broad phase from `begin` or `end`. Thread safety: none; a broad phase
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

/// A body's id fits 28 bits, because sorted lists of box ends (tests/engines/extent_ring.h) store
/// an id and one more bit in 29 bits.
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

/// `insert`    REQUIRES: the body is absent. Reports each overlap that begins.
/// `move`      REQUIRES: the body is present. Replaces its box; reports overlaps that begin or end.
/// `remove`    REQUIRES: the body is present. Reports that each of its overlaps ends.
/// `move_all`  Replaces the boxes of all present bodies at once, like a synchronous simulator
///             (thesis, Algorithm 3.4). REQUIRES: one box per id. Absent bodies' boxes are ignored.
/// `box`       Returns the body's newest box. REQUIRES: the body is present.
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
