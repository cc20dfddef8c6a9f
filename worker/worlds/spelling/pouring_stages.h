// Balls that spell as a world that acts in stages (worker/sampling/stages.h): stage i decides
// whether ball i takes part, and drops it.
//
// Ground: the offsets, drawn from the prior, and a pool of drops that an island's particles share.
// Each drop of the pool is simulated once as a ball that falls alone, so that a particle may look
// at all of them before it chooses. The pool has a stratum for each designated bin b, of n drops
// from
//
//   q_b = prior_share p + (1 - prior_share) d_b,
//
// p the prior's density of a drop, d_b that of BinDrops (landing_map.h). With q the mean of all
// q_b, a drop at x has v = p(x) / q(x).
//
// Choice. A ball takes part with probability `takes_part` (1/2 in the prior). If it does, an unused
// drop j of the pool is chosen with probability v_j s_j g_j / S, S the sum over unused ones. g_j
// guesses how likely it is that the ball fills an empty bin; s_j = n / (n - used drops of j's
// stratum) makes up for those that are used. The weight is
//
//   (1/2) / takes_part  S / (K g_j),   K all drops of the pool.
//
// Why that is right on average over pools: the probability of a sequence of drops times its weights
// is the product of v_j s_j / K; drops of a sequence are different ones of the pool, so
// independent; summed over the unused ones of a stratum, s_j / K comes to (n / K) q_b, over strata
// to q, and q v is p. It needs n to be at least the number of balls, so that no stratum is ever
// used up.
//
// Given a state (ground_given), its drops' places in the pool are drawn one after another: the
// stratum b with probability proportional to q_b at the drop, then an unused place of it; the rest
// of the pool is drawn as always.
//
// Potential: p_c of the prefix, lambda for each bin that is filled; exp(log_elsewhere) for each
// ball that fills no bin or a full one; and for each filled bin 1 / (the share of prior drops that
// fill it alone, by the pool): a bin that is hard to fill is worth more.
//
// Thread safety: const functions may be called from several threads at once.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/random/stream.h"
#include "worker/sampling/burn_in_judge.h"
#include "worker/sampling/stages.h"
#include "worker/worlds/spelling/landing_map.h"
#include "worker/worlds/spelling/pouring.h"
#include "worker/worlds/spelling/pouring_builder.h"
#include "worker/worlds/spelling/spelling.h"

namespace sleight::worlds::spelling {

/// How likely it is that a ball fills an empty bin, by what it would do alone, what lies below its
/// drop, and how far the nearest empty bin is. Any values above 0 are right; these are guesses,
/// from how often balls did in islands of HI.
struct DropOdds {
  /// By distance of the nearest empty bin's middle from the drop, in bins: below 1, 1.5, 2.5, more.
  using ByDistance = std::array<double, 4>;
  double own_bin = 0.95;                     ///< alone it fills the empty bin below it
  ByDistance beside{0.96, 0.8, 0.54, 0.45};  ///< another empty bin, and is not above a full one
  ByDistance above_full{0.41, 0.12, 0.12, 0.01};  ///< an empty bin, but is above a full one
  ByDistance meets_full{0.2, 0.1, 0.045, 0.003};  ///< none; it falls onto or into a full one
  ByDistance misses{0.03, 0.012, 0.005, 0.001};   ///< none, far from full ones
};

/// Drops of an island's pool by designated bin, where there are not more balls.
inline constexpr std::uint32_t k_drops_per_bin_min = 40;
/// Where only the odds are asked for, four for each ball, up to a limit: what a pool lacks all
/// particles lack.
inline constexpr std::uint32_t k_drops_per_bin_max = 120;

/// Frozen before anything counts.
struct PouringGuide {
  LandingMap map;
  std::vector<plan::FailurePointer> failures{};  ///< of the lone balls that the map is made of
  DropOdds odds{};
  double takes_part = 0.98;   ///< in (0, 1); learn gives all balls together one fifth to stay out
  double log_elsewhere = -3;  ///< -infinity: prefixes with a ball elsewhere are never gone on with
  /// Then a ball elsewhere is worth the less, the fewer balls are to come that may push it.
  bool elsewhere_declines = false;
  double prior_share = 0.15;  ///< in (0, 1]
  std::uint32_t drops_per_bin =
      k_drops_per_bin_min;  ///< at least; never fewer than there are balls
};

/// Batches of lone balls that a run's map is learnt from: 2,000 balls; more make no search faster.
inline constexpr std::uint64_t k_landing_batches = 20;

/// A drop of an island's pool.
struct PoolDrop {
  Vec2 drop_m{0, 0};
  double v = 0;                       ///< 0: outside of the region that balls are dropped from
  std::int16_t alone = k_fills_none;  ///< the bin that it fills alone
  std::int16_t below = k_fills_none;  ///< the designated bin below it
  /// The nearest designated bins, and which of DropOdds::ByDistance each is; k_fills_none where
  /// there are fewer.
  std::array<std::int16_t, 8> near{};
  std::array<std::uint8_t, 8> near_range{};
};

struct PouringGround {
  std::vector<Vec3> offsets_m;
  std::vector<PoolDrop> pool;       ///< stratum by stratum
  std::vector<double> bin_share{};  ///< by bin: of prior drops, those that fill it alone
  double mean_share = 0;            ///< over bins
  /// By ball: the place in the pool of the drop that a given state has; k_no_drop for a ball that
  /// takes no part, and where no state is given.
  std::vector<std::uint32_t> retained{};
  std::vector<sampling::SimulationReport> failed{};  ///< lone balls of the pool
};
inline constexpr std::uint32_t k_no_drop = UINT32_MAX;

struct PouringPrefix {
  Pouring pouring;
  std::vector<std::uint8_t> is_used{};       ///< by drop of the pool
  std::vector<std::uint32_t> used_of_bin{};  ///< by stratum
};

class StagedSpelling : public Spelling {
 public:
  using Guide = PouringGuide;
  using Ground = PouringGround;
  using Prefix = PouringPrefix;
  using Spelling::Spelling;

  /// The guide of all runs with this seed.
  Guide learn(std::uint64_t seed) const;
  std::span<const plan::FailurePointer> failures_of(const Guide& guide) const {
    return guide.failures;
  }
  PouringBuilder builder(const Guide& guide) const { return PouringBuilder(*this, guide.map); }
  /// A search leaves out balls that another one helped into their bins (helped_balls), and so does
  /// every chain's start.
  std::vector<sampling::BurnInValue> burn_in_values() const;
  std::vector<double> burn_in_values_of(const State& state, const Outcome& outcome) const;
  /// Balls that fill a bin which they would not fill alone. One that the simulator can't carry out
  /// alone counts among them: it is looked at, and no sample.
  std::uint32_t helped_balls(const State& state, const Outcome& outcome) const;

  std::uint32_t stages() const { return balls(); }
  /// For people: what solutions in proportion took before of words like this one.
  std::string past_effort() const;
  /// "ball 3 of 16".
  std::string stage_name(std::uint32_t stage) const;
  Ground draw_ground(const Guide& guide, random::Stream& stream) const;
  Ground ground_given(const Guide& guide, const State& state, random::Stream& stream) const;
  Prefix no_stages(const Guide& guide, const Ground& ground) const;
  sampling::Extension extend(const Guide& guide, const Ground& ground, std::uint32_t stage,
                             Prefix& prefix, random::Stream& stream) const;
  sampling::Extension extend_as(const Guide& guide, const Ground& ground, const State& state,
                                std::uint32_t stage, Prefix& prefix) const;
  /// The guide of islands whose particles choose together. Where these are resampled at each stage,
  /// a ball elsewhere has to be worth about what it may still come to, or all prefixes with one are
  /// lost, and with them what later balls would have pushed into its bin: of two or three balls a
  /// tenth of all that satisfies.
  Guide for_odds(Guide guide) const;
  /// Of DropOdds, and last the ball's taking no part. Alternatives are numbered as drops of the
  /// pool.
  std::size_t sorts() const;
  std::vector<double> masses(const Guide& guide, const Ground& ground, std::uint32_t stage,
                             const Prefix& prefix) const;
  std::vector<sampling::Alternative> alternatives(const Guide& guide, const Ground& ground,
                                                  std::uint32_t stage, const Prefix& prefix,
                                                  std::size_t sort) const;
  sampling::Extension take(const Guide& guide, const Ground& ground, std::uint32_t stage,
                           std::size_t number, Prefix& prefix) const;
  double log_potential(const Guide& guide, const Ground& ground, const Prefix& prefix) const;
  State state_of(const Ground& /*ground*/, const Prefix& prefix) const {
    return prefix.pouring.state;
  }
  Outcome outcome_of(const Prefix& prefix) const { return prefix.pouring.outcome; }
  /// Lone balls of the pool that failed: guesses that are wrong at worst.
  std::span<const sampling::SimulationReport> simulations_of(const Ground& ground) const {
    return ground.failed;
  }

  /// q of a stratum, 1/m^2. REQUIRES: inside the region that balls are dropped from.
  double density_of_stratum(const Guide& guide, std::size_t bin, const Vec2& drop_m) const;

 private:
  /// How the unused drops of a pool are chosen after a prefix.
  struct Choices {
    std::vector<double> guesses;  ///< g; 0 of drops that can't be chosen
    std::vector<double> shares;   ///< v s g
    double sum = 0;               ///< S
  };

  std::uint32_t drops_per_bin(const Guide& guide) const;
  Vec2 draw_of_stratum(const Guide& guide, std::size_t bin, random::Stream& stream) const;
  /// A ground without drops.
  Ground empty_ground(const Guide& guide, std::vector<Vec3> offsets_m) const;
  void find_near_bins(PoolDrop& drop) const;
  /// Puts a drop of the pool in its place, and simulates it alone.
  void look_at(const Guide& guide, const Vec2& drop_m, std::size_t place, Ground& ground) const;
  /// Draws the places that hold no retained drop, and looks at all.
  void fill_pool(const Guide& guide, random::Stream& stream, Ground& ground,
                 std::span<const std::uint8_t> is_retained) const;
  Choices choices(const Guide& guide, const Ground& ground, const Prefix& prefix) const;
  /// Visits each drop that can be chosen with its place, its sort of DropOdds, g and v s g.
  template <class Visit>
  void for_each_choice(const Guide& guide, const Ground& ground, const Prefix& prefix,
                       const Visit& visit) const;
  double mass_left_out(const Guide& guide, double mass_of_drops) const;
  /// Of a drop that was chosen so.
  double log_weight_of(const Guide& guide, const Ground& ground, const Choices& choices,
                       std::size_t place) const;
  /// Without the ball.
  sampling::Extension leave_out(const Guide& guide) const;
  /// With the ball at this drop of the pool, which has this weight.
  sampling::Extension drop(const Guide& guide, const Ground& ground, std::uint32_t stage,
                           std::size_t place, Prefix& prefix, double log_weight) const;
};

static_assert(sampling::ActsInStages<StagedSpelling>);

}  // namespace sleight::worlds::spelling
