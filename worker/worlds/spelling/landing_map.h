// Where a ball has to be dropped to come to rest in a bin, learnt from balls that fall alone.
//
// A lone ball that fills a designated bin was dropped at some displacement from the bin's middle.
// Bins are alike and their box is as good as symmetric, so displacements of all bins are counted
// together, each with its eight mirror images. The map says nothing of a place farther than
// k_reach bins, and little of a rare one: whoever draws from it mixes it with other draws.
//
// Landings are counted in batches, each a pure function of the run's seed and its number, so that
// any number of workers learn one map. Thread safety: values and pure functions.
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

/// How often lone balls were dropped at a displacement from the bin that they filled, by cell of a
/// square grid.
class Landings {
 public:
  /// Cells along the pitch of two bins, and bins that the grid reaches to each side.
  static constexpr std::uint32_t k_cells = 10;
  static constexpr double k_reach = 4.5;
  static constexpr std::uint32_t k_side = 90;  ///< cells: 2 k_reach k_cells
  static_assert(k_side == 2 * k_reach * k_cells);

  /// `pitch_m`: from the middle of a bin to that of the next.
  explicit Landings(double pitch_m) : pitch_m_(pitch_m), counts_(std::size_t{k_side} * k_side, 0) {}

  /// Counts a displacement and its mirror images; those out of reach are left out.
  void add(const Vec2& displacement_m);
  /// REQUIRES: the same pitch.
  void add(const Landings& other);
  /// Displacements within reach, mirror images included.
  std::uint64_t total() const { return total_; }
  std::uint64_t count(std::size_t cell) const { return counts_[cell]; }
  double pitch_m() const { return pitch_m_; }
  /// Of balls that failed in the simulator, and so count as landed nowhere.
  const std::vector<plan::FailurePointer>& failures() const { return failures_; }
  void add_failure(plan::FailurePointer failure) { failures_.push_back(std::move(failure)); }

 private:
  double pitch_m_;
  std::vector<std::uint32_t> counts_;  ///< row by row from the least displacements
  std::uint64_t total_ = 0;
  std::vector<plan::FailurePointer> failures_{};
};

/// The `batch`-th balls of a run: so many, dropped anywhere, on one box of the prior.
inline constexpr std::uint32_t k_landings_of_batch = 100;
Landings landings_of_batch(const Spelling& world, std::uint64_t seed, std::uint64_t batch);
/// Of batches 0, 1, ...
Landings landings_of(const Spelling& world, std::uint64_t seed, std::uint64_t batches);

/// Landings as a density that can be drawn from.
class LandingMap {
 public:
  /// Without any landing all displacements within reach are alike.
  explicit LandingMap(const Landings& landings);

  /// A displacement from the bin's middle.
  Vec2 draw(random::Stream& stream) const;
  /// 1/m^2; 0 out of reach.
  double density(const Vec2& displacement_m) const;

 private:
  double cell_m_;
  std::vector<double> shares_;      ///< by cell
  std::vector<double> cumulative_;  ///< up to and with each cell; the last is 1
};

/// The share of drops for a bin from a window about it (Windows), which reach where the map has
/// nothing.
inline constexpr double k_window_share = 0.15;

/// Drops for a designated bin: from its window, or from the map about its middle. Some lie where no
/// ball is dropped. REQUIRES: world and map outlive it.
class BinDrops {
 public:
  BinDrops(const Spelling& world, const LandingMap& map) : world_(&world), map_(&map) {}
  Vec2 draw(std::size_t bin, random::Stream& stream) const;
  /// 1/m^2, of drops that lie where a ball may be dropped.
  double density(std::size_t bin, const Vec2& drop_m) const;

 private:
  const Spelling* world_;
  const LandingMap* map_;
};

}  // namespace sleight::worlds::spelling
