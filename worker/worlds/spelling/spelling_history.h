// A simulation of spelling balls stores a history. Simulations of similar states use the history. A
// history contains each ball's history (physics/marbles/marbles.h), and all balls' places at each
// look. A look is a test of whether all balls stay.
// Thread safety: const functions may be called from several threads at once.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "worker/physics/marbles/marbles.h"
#include "worker/worlds/spelling/bins.h"
#include "worker/worlds/spelling/proposals.h"
#include "worker/worlds/spelling/traps.h"

namespace sleight::worlds::spelling {

/// A ball's state at a look. A suspended ball (Marbles) has its state at the time of suspension.
struct Seen {
  Traps::Ball ball;
  bool was_alone = false;
};

struct SpellingHistory {
  physics::MarbleHistories histories;  ///< by ball
  std::vector<physics::Tick> looks;
  std::vector<Seen> seen;                 ///< by look: the active balls
  std::vector<std::uint32_t> flat_edges;  ///< flat edges of the box (Influence)
  double border_m = 0;                    ///< of the box (StaticGeometry::border_m)
  std::uint64_t simulated = 0;  ///< events simulated to build this history (Marbles::Counts::work)

  /// Returns all balls' observations at a tick. If that tick had no look, the result is empty.
  std::span<const Seen> seen_at(physics::Tick tick) const {
    const auto found = std::ranges::lower_bound(looks, tick);
    if (found == looks.end() || *found != tick) return {};
    const std::size_t active = seen.size() / looks.size();
    return std::span(seen).subspan(static_cast<std::size_t>(found - looks.begin()) * active,
                                   active);
  }
  std::size_t bytes() const {
    std::size_t bytes = sizeof(*this) + histories.capacity() * sizeof(histories[0]);
    for (const auto& history : histories)
      bytes += history ? history->bytes() : 0;
    bytes += flat_edges.capacity() * sizeof(flat_edges[0]);
    bytes += looks.capacity() * sizeof(looks[0]) + seen.capacity() * sizeof(seen[0]);
    return bytes;
  }
};

/// Whether a ball is active in both states and starts in the same place.
bool starts_alike(const State& state, const State& candidate, std::size_t ball);
/// Whether a candidate and a state have at least half of the box in common, and at least one ball
/// that starts alike. If less of the box is common, balls differ from their first collision on.
bool resembles(const State& candidate, const State& state);

/// Returns the histories of balls that start alike. These histories hold for the candidate too.
physics::MarbleHistories histories_that_hold(const SpellingHistory& history, const State& state,
                                             const State& candidate);

/// For each partition vertex, the parts of the geometry that depend on it.
class Influence {
 public:
  /// `statics` is a physics scene's geometry. REQUIRES: the scene's only mesh is the bins' surface.
  Influence(const Bins& bins, const physics::StaticGeometry& statics);
  /// Returns a moved surface's flat edges whose vertices can move. Usually there are none.
  std::vector<std::uint32_t> flat_edges(const physics::TriangleMesh& surface) const;
  /// Returns the differences between two boxes that have different offsets. The differences include
  /// edges that are flat in either box. The result refers to this object.
  std::vector<physics::MarbleChange> changes(std::span<const Vec3> before_m,
                                             std::span<const std::uint32_t> flat_before,
                                             std::span<const Vec3> after_m,
                                             std::span<const std::uint32_t> flat_after) const;

 private:
  struct Vertex {
    physics::StaticGeometry::About about;
    std::vector<std::uint32_t> corners;  ///< of all triangles in `about`
  };
  std::vector<Vec3> vertices_m_;  ///< without offsets
  std::vector<Vertex> of_vertex_;
  std::vector<std::uint32_t> edges_;  ///< of any vertex, ascending
};

}  // namespace sleight::worlds::spelling
