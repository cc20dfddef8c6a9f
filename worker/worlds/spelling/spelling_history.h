// The history that a simulation of spelling balls leaves for those of similar states: each ball's
// history (physics/marbles/marbles.h), and the places of all balls at each test of whether they
// stay.
//
// Thread safety: const functions may be called from several threads at once.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "worker/physics/marbles/marbles.h"
#include "worker/worlds/spelling/bins.h"
#include "worker/worlds/spelling/proposals.h"
#include "worker/worlds/spelling/traps.h"

namespace sleight::worlds::spelling {

/// What was seen of a ball: as it was at that time, or, of one that was left alone, when it was.
struct Seen {
  Traps::Ball ball;
  bool was_alone = false;
};

struct SpellingHistory {
  physics::MarbleHistories histories;  ///< by ball
  std::vector<physics::Tick> looks;
  std::vector<Seen> seen;                 ///< by look, those balls that are active
  std::vector<std::uint32_t> flat_edges;  ///< of the box (Influence)
  double border_m = 0;                    ///< of the box (StaticGeometry::border_m)
  std::uint64_t simulated = 0;  ///< events that it took to know all this (Marbles::Counts::work)

  /// What was seen of all balls at a tick; nothing if that tick had no look.
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

/// Whether a ball takes part in both and starts in the same place.
bool starts_alike(const State& state, const State& candidate, std::size_t ball);
/// Whether a candidate may have something in common with a state: a ball that starts alike, and at
/// least half of the box, without which balls differ from their first collision on.
bool resembles(const State& candidate, const State& state);

/// The histories that hold for a candidate as well: those of balls that start as they did.
physics::MarbleHistories histories_that_hold(const SpellingHistory& history, const State& state,
                                             const State& candidate);

/// What hangs on each partition vertex.
class Influence {
 public:
  /// `statics`: of a scene with the bins' surface for its only mesh.
  Influence(const Bins& bins, const physics::StaticGeometry& statics);
  /// Those edges of the bins' surface as it is that are flat, though its vertices move: none,
  /// mostly.
  std::vector<std::uint32_t> flat_edges(const physics::TriangleMesh& surface) const;
  /// What is otherwise in a box whose vertices have other offsets, and which of its edges were flat
  /// and are. Refers to this.
  std::vector<physics::MarbleChange> changes(std::span<const Vec3> before_m,
                                             std::span<const std::uint32_t> flat_before,
                                             std::span<const Vec3> after_m,
                                             std::span<const std::uint32_t> flat_after) const;

 private:
  struct Vertex {
    physics::StaticGeometry::About about;
    std::vector<std::uint32_t> corners;  ///< of all triangles in that
  };
  std::vector<Vec3> vertices_m_;  ///< of the surface without offsets
  std::vector<Vertex> of_vertex_;
  std::vector<std::uint32_t> edges_;  ///< of any vertex, ascending
};

}  // namespace sleight::worlds::spelling
