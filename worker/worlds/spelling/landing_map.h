// A map that tells where to drop a ball so that it comes to rest in a bin. The map is learnt from
// balls that fall alone.
//
// A lone ball that fills a designated bin was dropped at some displacement from the bin's middle.
// Bins are alike, so displacements of all bins are counted together. The box is nearly symmetric,
// so a displacement counts with its eight mirror images. The map has no data beyond k_reach bins,
// and little about rare displacements. So users of the map also draw from other densities.
//
// Landings are counted in batches. Each batch is a pure function of the run's seed and the batch's
// number, so any number of workers learn the same map. Thread safety: values and pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "common/math/vector.h"
#include "common/plan/failure.h"
#include "common/random/stream.h"
#include "worker/worlds/spelling/spelling.h"

namespace sleight::worlds::spelling {

/// Numbers of lone balls in the cells of a square grid. A ball's displacement from the filled bin
/// to the drop is in the ball's cell.
class Landings {
 public:
  /// k_cells is the number of cells per bin pitch. k_reach is the grid's reach to each side, in
  /// bins.
  static constexpr std::uint32_t k_cells = 10;
  static constexpr double k_reach = 4.5;
  static constexpr std::uint32_t k_side = 90;  ///< cells per side: 2 k_reach k_cells
  static_assert(k_side == 2 * k_reach * k_cells);

  /// `pitch_m`: distance between the middles of neighbouring bins.
  explicit Landings(double pitch_m) : pitch_m_(pitch_m), counts_(std::size_t{k_side} * k_side, 0) {}

  /// Counts a displacement and its mirror images. Ignores displacements out of reach.
  void add(const Vec2& displacement_m);
  /// REQUIRES: the same pitch.
  void add(const Landings& other);
  /// Number of displacements within reach, mirror images included.
  std::uint64_t total() const { return total_; }
  std::uint64_t count(std::size_t cell) const { return counts_[cell]; }
  double pitch_m() const { return pitch_m_; }
  /// Failed simulations. If a ball's simulation failed, the ball doesn't count as landed.
  const std::vector<plan::FailurePointer>& failures() const { return failures_; }
  void add_failure(plan::FailurePointer failure) { failures_.push_back(std::move(failure)); }

 private:
  double pitch_m_;
  std::vector<std::uint32_t> counts_;  ///< row by row from the least displacements
  std::uint64_t total_ = 0;
  std::vector<plan::FailurePointer> failures_{};
};

/// Balls per batch. A batch draws a box from the prior. Each ball is dropped anywhere on the box.
inline constexpr std::uint32_t k_landings_of_batch = 100;
Landings landings_of_batch(const Spelling& world, std::uint64_t seed, std::uint64_t batch);
/// Returns the sum of the first `batches` batches.
Landings landings_of(const Spelling& world, std::uint64_t seed, std::uint64_t batches);

/// A density of displacements, estimated from landings.
class LandingMap {
 public:
  /// If there are no landings, all displacements within reach are equally likely.
  explicit LandingMap(const Landings& landings);

  Vec2 draw(random::Stream& stream) const;
  /// Returns the density in 1/m^2; 0 out of reach.
  double density(const Vec2& displacement_m) const;

 private:
  double cell_m_;
  std::vector<double> shares_;      ///< by cell
  std::vector<double> cumulative_;  ///< up to and including each cell; the last is 1
};

/// Share of a bin's drops that come from the bin's window (Windows). The window reaches places
/// where the map has no landings.
inline constexpr double k_window_share = 0.15;

/// Drops for a designated bin. Drops are drawn from the bin's window, or from the map around the
/// bin's middle. Some drops are outside the drop region. REQUIRES: world and map outlive the drops.
class BinDrops {
 public:
  BinDrops(const Spelling& world, const LandingMap& map) : world_(&world), map_(&map) {}
  Vec2 draw(std::size_t bin, random::Stream& stream) const;
  /// Returns the density in 1/m^2, valid inside the drop region.
  double density(std::size_t bin, const Vec2& drop_m) const;

 private:
  const Spelling* world_;
  const LandingMap* map_;
};

}  // namespace sleight::worlds::spelling
