// Reimplements islands and their chains for the staged toy, slowly and plainly. Can make one
// mistake. Without a mistake, results equal those of the real code (worker/sampling/island.h,
// particle_steps.h, worker/run/island_scan.h) bit by bit. So each mistake corresponds to a mistake
// in the real algorithm.
//
// The reference uses the real code's random numbers, sums of logs and toy, because they have their
// own tests. Everything that determines weights, resampling, draws and acceptance is reimplemented.
// Thread safety: values and pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "tests/statistical/support/staged_toy.h"
#include "worker/sampling/island.h"

namespace sleight::statistical {

inline constexpr StagedToy k_toy{};

/// A mistake of the reference. island_mistakes.cpp explains why a check detects it.
enum class Mistake {
  none,
  // Weights of a free island, and Z.
  choice_weight_left_out,
  potential_of_another_prefix,
  potential_never_taken_off,
  potential_stays_at_the_end,
  temperature_forgotten,
  resampled_keep_weights,
  mean_weight_left_out,
  resampled_by_squares,
  dead_left_out_of_the_mean,
  dead_islands_made_again,
  stages_share_numbers,
  rescued_left_out,
  // P(satisfied), and the draw.
  constraint_left_in_satisfied,
  satisfied_are_counted,
  satisfied_without_earlier_weights,
  drawn_without_weights,
  // The retained path.
  retained_drawn_anew,
  retained_resampled_away,
  retained_put_over_another,
  retained_weighs_one,
  retained_never_drawn,
  ground_drawn_anew,
  // The chain.
  every_island_accepted,
  accepted_by_the_draw,
  rejected_island_gives_z,
  stale_z_kept,
  stale_z_of_a_free_island,
  fresh_island_spared,
  unreachable_state_leaves,
  guide_learns_from_the_chain,
  start_of_a_search_counts,
};

/// As sampling::Island.
struct ReferenceIsland {
  double log_z = sampling::k_log_zero;
  double log_satisfied = sampling::k_log_zero;
  std::optional<StagedToy::State> drawn{};
  double effective_size = 0;
  std::uint32_t satisfied = 0;
  bool is_unreachable = false;
};

struct IslandSetting {
  StagedToy::Guide guide{};
  sampling::IslandOptions options{};
};

/// As sampling::Islands.
class ReferenceIslands {
 public:
  using Toy = StagedToy;

  ReferenceIslands(const IslandSetting& setting, const sampling::ChainStreams& streams,
                   Mistake mistake);

  ReferenceIsland free(std::uint64_t number) const;
  ReferenceIsland given(std::uint64_t number, Toy::State state) const;
  random::Stream acceptance_of(std::uint64_t number) const;

 private:
  struct Particle {
    Toy::Prefix prefix{};
    double log_weight = 0;     ///< Since the last resampling; -infinity: dead.
    double log_potential = 0;  ///< The potential included in log_weight.
    bool is_dead() const { return log_weight == sampling::k_log_zero; }
  };
  struct Making {
    std::uint64_t number = 0;
    std::optional<Toy::State> retained{};
    Toy::Ground ground = 0;
    std::vector<Particle> particles{};
    double log_z_before = 0;  ///< Log of Z's factors from the resamplings so far.
  };

  bool makes(Mistake mistake) const { return mistake_ == mistake; }
  random::Stream stream_of(random::Purpose purpose, std::uint64_t number, std::uint32_t stage,
                           std::uint32_t particle) const;
  ReferenceIsland made(std::uint64_t number, std::optional<Toy::State> retained) const;
  Making begun(std::uint64_t number, std::optional<Toy::State> retained) const;
  void extend(Making& making, std::uint32_t stage, std::uint32_t n) const;
  void resample(Making& making, std::uint32_t stage) const;
  std::vector<std::uint32_t> ancestors(const Making& making, random::Stream& stream) const;
  double log_mean_weight(const Making& making) const;
  double log_satisfied(const Making& making) const;
  std::uint32_t drawn_particle(const Making& making) const;
  ReferenceIsland finished(const Making& making) const;

  IslandSetting setting_;
  sampling::ChainStreams streams_;
  Mistake mistake_;
};

/// As sampling::ParticleSample.
struct ReferenceChain {
  StagedToy::State state = 0;
  std::optional<double> log_z{};
};

class ReferenceSteps {
 public:
  ReferenceSteps(const IslandSetting& setting, const sampling::ChainStreams& streams,
                 Mistake mistake)
      : setting_(setting), streams_(streams), mistake_(mistake) {}

  /// As sampling::conditional_step and independence_step.
  void conditional(std::uint64_t number, ReferenceChain& chain) const;
  void independent(std::uint64_t number, ReferenceChain& chain) const;
  /// Like sampling::metropolis_hastings_step(). If the state changes, Z becomes stale.
  void local(std::uint64_t iteration, ReferenceChain& chain) const;
  /// As run::IslandScan::visit.
  void visit(std::uint64_t scan, ReferenceChain& chain) const;

 private:
  bool makes(Mistake mistake) const { return mistake_ == mistake; }
  ReferenceIslands islands(const ReferenceChain& chain) const;

  IslandSetting setting_;
  sampling::ChainStreams streams_;
  Mistake mistake_;
};

}  // namespace sleight::statistical
