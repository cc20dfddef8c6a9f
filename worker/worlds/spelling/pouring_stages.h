// The spelling world's stages (worker/sampling/stages.h). Stage i decides whether ball i takes
// part, and drops it.
//
// The ground has the offsets, which are drawn from the prior, and a pool of drops. An island's
// particles share the pool. Each drop of the pool is simulated once as a ball that falls alone, so
// a particle can compare all drops before it chooses. For each designated bin b, the pool has a
// stratum of n drops drawn from
//
//   q_b = prior_share p + (1 - prior_share) d_b,
//
// where p is the prior's density of a drop, and d_b is the density of BinDrops (landing_map.h). Let
// q be the mean of all q_b. A drop at x has v = p(x) / q(x).
//
// Choice. A ball takes part with probability `takes_part` (1/2 in the prior). If it does, an unused
// drop j of the pool is chosen with probability v_j s_j g_j / S, where S is the sum over unused
// drops. The guess g_j estimates the probability that the ball fills an empty bin. The factor s_j =
// n / (n - used drops of j's stratum) compensates for used drops. The weight is
//
//   (1/2) / takes_part  S / (K g_j),   where K is the number of drops in the pool.
//
// The estimate is unbiased over pools. The probability of a sequence of drops times its weights is
// the product of v_j s_j / K. A sequence uses each drop of the pool at most once, so its drops are
// independent. The sum of s_j / K over the unused drops of a stratum gives (n / K) q_b. The sum
// over strata gives q, and q v = p. No stratum may be used up, so n must be at least the number of
// balls.
//
// If a state is given (ground_given), the state's drops get places in the pool, one drop after
// another. For each drop, a stratum b is drawn with probability proportional to q_b at the drop,
// and then an unused place in this stratum. The rest of the pool is drawn as usual.
//
// The potential has a factor lambda for each filled bin (p_c of the prefix). Another factor is
// exp(log_elsewhere) for each ball that fills no bin, such as a second ball in a bin. The pool also
// gives an estimate of the share of prior drops that fill a bin alone. Each filled bin contributes
// the inverse of its share. So a bin that is hard to fill is worth more.
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
#include "worker/worlds/spelling/pouring_builder.h"
#include "worker/worlds/spelling/spelling.h"

namespace sleight::worlds::spelling {

/// Estimated probability that a ball fills an empty bin. The estimate depends on three things:
/// where the ball would go alone, what is below its drop, and how far the nearest empty bin is. Any
/// values above 0 give correct results; the defaults are the frequencies in islands of HI.
struct DropOdds {
  /// Values by distance. A distance is from the drop to the nearest empty bin's middle, in bins.
  /// The ranges are below 1, below 1.5, below 2.5, and the rest.
  using ByDistance = std::array<double, 4>;
  double own_bin = 0.95;                     ///< alone, the ball fills the empty bin below it
  ByDistance beside{0.96, 0.8, 0.54, 0.45};  ///< alone: another empty bin; not above a full bin
  ByDistance above_full{0.41, 0.12, 0.12, 0.01};  ///< alone: an empty bin; above a full bin
  ByDistance meets_full{0.2, 0.1, 0.045, 0.003};  ///< alone: no empty bin; hits a full bin
  ByDistance misses{0.03, 0.012, 0.005, 0.001};   ///< alone: no bin; not above a full bin
};

/// Drops per designated bin in an island's pool. For each bin, a pool has at least as many drops as
/// there are balls.
inline constexpr std::uint32_t k_drops_per_bin_min = 40;
/// Maximum drops per designated bin if a request wants only odds. For each bin, pools for odds have
/// four drops per ball, because a drop that the shared pool lacks is missing for all particles.
inline constexpr std::uint32_t k_drops_per_bin_max = 120;

/// Fixed before sampling starts.
struct PouringGuide {
  LandingMap map;
  std::vector<plan::FailurePointer> failures{};  ///< of the lone balls for the map
  DropOdds odds{};
  double takes_part = 0.98;   ///< in (0, 1); after learn(), at most 0.2 balls stay out on average
  double log_elsewhere = -3;  ///< -infinity: prefixes with a ball elsewhere have potential 0
  /// If set, a ball that fills no bin loses worth as fewer later balls remain that may push it into
  /// a bin.
  bool elsewhere_declines = false;
  double prior_share = 0.15;                          ///< in (0, 1]
  std::uint32_t drops_per_bin = k_drops_per_bin_min;  ///< minimum; never below the number of balls
};

/// A run learns its map from this number of batches of lone balls, 2,000 balls in total. More balls
/// don't make searches faster.
inline constexpr std::uint64_t k_landing_batches = 20;

struct PoolDrop {
  Vec2 drop_m{0, 0};
  double v = 0;                       ///< 0: outside the drop region
  std::int16_t alone = k_fills_none;  ///< the bin that the ball fills alone
  std::int16_t below = k_fills_none;  ///< the designated bin below the drop
  /// The nearest designated bins, and the range of each in DropOdds::ByDistance. Unused entries are
  /// k_fills_none.
  std::array<std::int16_t, 8> near{};
  std::array<std::uint8_t, 8> near_range{};
};

struct PouringGround {
  std::vector<Vec3> offsets_m;
  std::vector<PoolDrop> pool;       ///< stratum by stratum
  std::vector<double> bin_share{};  ///< by bin: share of prior drops that fill it alone
  double mean_share = 0;            ///< over bins
  /// By ball: the pool's place that contains the given state's drop. k_no_drop if the ball takes no
  /// part, or if no state is given.
  std::vector<std::uint32_t> retained{};
  std::vector<sampling::SimulationReport> failed{};  ///< lone balls of the pool that failed
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

  /// Returns the guide that all runs with this seed share.
  Guide learn(std::uint64_t seed) const;
  std::span<const plan::FailurePointer> failures_of(const Guide& guide) const {
    return guide.failures;
  }
  PouringBuilder builder(const Guide& guide) const { return PouringBuilder(*this, guide.map); }
  /// The values include the number of helped balls: a search never builds helped balls, so every
  /// chain starts without any.
  std::vector<sampling::BurnInValue> burn_in_values() const;
  std::vector<double> burn_in_values_of(const State& state, const Outcome& outcome) const;
  /// Counts helped balls, which fill a bin that they wouldn't fill alone. A ball whose lone
  /// simulation fails counts as helped, since its simulation isn't a sample.
  std::uint32_t helped_balls(const State& state, const Outcome& outcome) const;

  std::uint32_t stages() const { return balls(); }
  /// Returns a sentence for people. The sentence says how long earlier runs took to draw solutions
  /// of similar words in the model's proportions.
  std::string past_effort() const;
  /// Returns a name such as "ball 3 of 16".
  std::string stage_name(std::uint32_t stage) const;
  Ground draw_ground(const Guide& guide, random::Stream& stream) const;
  Ground ground_given(const Guide& guide, const State& state, random::Stream& stream) const;
  Prefix no_stages(const Guide& guide, const Ground& ground) const;
  sampling::Extension extend(const Guide& guide, const Ground& ground, std::uint32_t stage,
                             Prefix& prefix, random::Stream& stream) const;
  sampling::Extension extend_as(const Guide& guide, const Ground& ground, const State& state,
                                std::uint32_t stage, Prefix& prefix) const;
  /// Returns the guide for islands whose particles choose together. Particles that choose together
  /// are resampled at each stage, so the potential of a ball that fills no bin must be close to
  /// what the ball may still contribute. Otherwise all prefixes with such a ball are lost.
  /// Animations in which a later ball pushes that ball into its bin are lost too. If there are two
  /// or three balls, such animations are a tenth of all solutions.
  Guide for_odds(Guide guide) const;
  /// Number of sorts of alternatives. First come the sorts of DropOdds; the last sort leaves the
  /// ball out. Alternatives are numbered like the pool's drops.
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
  /// Returns the pool's failed lone balls. At worst, a failed lone ball gives a wrong guess.
  std::span<const sampling::SimulationReport> simulations_of(const Ground& ground) const {
    return ground.failed;
  }

  /// Returns q_b of a stratum, 1/m^2. REQUIRES: the drop is inside the drop region.
  double density_of_stratum(const Guide& guide, std::size_t bin, const Vec2& drop_m) const;

 private:
  /// How a prefix chooses among a pool's unused drops.
  struct Choices {
    std::vector<double> guesses;  ///< g; 0 for drops that can't be chosen
    std::vector<double> shares;   ///< v s g
    double sum = 0;               ///< S
  };

  std::uint32_t drops_per_bin(const Guide& guide) const;
  Vec2 draw_of_stratum(const Guide& guide, std::size_t bin, random::Stream& stream) const;
  Ground empty_ground(const Guide& guide, std::vector<Vec3> offsets_m) const;
  void find_near_bins(PoolDrop& drop) const;
  /// Stores a drop at its place in the pool, and simulates it alone.
  void look_at(const Guide& guide, const Vec2& drop_m, std::size_t place, Ground& ground) const;
  /// Draws all drops that aren't retained, then simulates each drop alone.
  void fill_pool(const Guide& guide, random::Stream& stream, Ground& ground,
                 std::span<const std::uint8_t> is_retained) const;
  Choices choices(const Guide& guide, const Ground& ground, const Prefix& prefix) const;
  /// Visits each drop that can be chosen. The arguments are the drop's place, its sort (as in
  /// DropOdds), g, and v s g.
  template <class Visit>
  void for_each_choice(const Guide& guide, const Ground& ground, const Prefix& prefix,
                       const Visit& visit) const;
  double mass_left_out(const Guide& guide, double mass_of_drops) const;
  /// Returns the log weight of a drop that was chosen by `choices`.
  double log_weight_of(const Guide& guide, const Ground& ground, const Choices& choices,
                       std::size_t place) const;
  sampling::Extension leave_out(const Guide& guide) const;
  sampling::Extension drop(const Guide& guide, const Ground& ground, std::uint32_t stage,
                           std::size_t place, Prefix& prefix, double log_weight) const;
};

static_assert(sampling::ActsInStages<StagedSpelling>);

}  // namespace sleight::worlds::spelling
