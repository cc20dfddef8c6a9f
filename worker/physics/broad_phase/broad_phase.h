// Broad phase: reports which bodies' boxes begin or stop overlapping.
//
// Idea. A simulator watches only pairs of bodies whose temporal bounding volumes overlap (thesis
// 3.2.1). A broad phase stores the boxes. When a box changes, the broad phase reports to a sink
// which overlaps begin or end. A broad phase need not store overlapping pairs: the simulator lists
// each body's neighbours anyway, and the sink returns the list (`neighbours()`).
//
// The simulator uses HierarchicalGrid, a hash of cells per box size. Tests compare HierarchicalGrid
// with other broad phases (tests/engines).
//
// Invariants
//   1. At every moment, the pairs reported as begun and not as ended are the pairs of present
//      bodies whose boxes overlap (periodic.h). So all broad phases report the same pairs in the
//      same call.
//   2. Each call reports each pair at most once. An overlap that continues isn't reported.
//   3. The order of a call's reports depends only on the calls so far. The order differs between
//      broad phases, so results must not depend on the order.
//   4. Once the lists have grown to the scene's needs, no memory is allocated.
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

/// Ids are limited to 28 bits, because tests/engines/extent_ring.h stores an id and one more bit in
/// 29 bits.
inline constexpr std::uint32_t k_bodies_max = std::uint32_t{1} << 28;

/// Receives the reports about one body. `neighbours()` returns the bodies that overlap this body,
/// according to the reports so far. The result is valid until the next begin or end.
template <class T>
concept OverlapSink = requires(T& sink, BodyId other) {
  sink.begin(other);
  sink.end(other);
  { sink.neighbours() } -> std::convertible_to<std::span<const BodyId>>;
};

/// Receives the reports about all bodies. The first argument is the pair's lower id.
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

/// `insert`    Adds the body; reports each overlap that begins. REQUIRES: the body is absent.
/// `move`      Replaces the body's box; reports each overlap that begins or ends. REQUIRES: the
///             body is present.
/// `remove`    Removes the body; reports each overlap that ends. REQUIRES: the body is present.
/// `move_all`  Replaces the boxes of all present bodies at once, as a synchronous simulator does
///             (thesis, Algorithm 3.4). REQUIRES: one box per id. Absent bodies' boxes are ignored.
/// `box`       Returns the body's newest box. REQUIRES: the body is present.
/// Each box has low <= high. A box may be a point, and may be infinite.
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
