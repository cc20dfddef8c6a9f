// Splitting: estimates how rarely prior draws satisfy, by nested sets of states.
//
// A world judges stages in order, and rates how near a state is to passing the next stage
// (Progress). So each level, a least progress, is a set of states within the set of the level
// before. The last level has the states that satisfy.
//
//   Island of N particles:
//     Draw each particle from the prior.
//     For each level:
//       P *= share of particles that are within the level. If there is none: P = 0.
//       Resample those within. Move each particle several times, by Metropolis-Hastings steps that
//       keep the prior and reject what leaves the level.
//
// The mean of P over islands is P(satisfied), for any number of particles and of moves: levels and
// moves are fixed before. A first island, which doesn't count, finds them (find_levels): its levels
// keep about a third of its own particles, which move until enough moves are accepted. An island
// that chose levels by its own particles would make P too small or too large on average.
//
// Invariant: an island is a pure function of its seed, its number, the levels and the number of
// particles.
// Sources: Kahn and Harris, Estimation of particle transmission by random sampling (1951); Au and
// Beck, Estimation of small failure probabilities (2001); Cerou, Del Moral, Furon, Guyader,
// Sequential Monte Carlo for rare event estimation (2012).
#pragma once

#include <algorithm>
#include <compare>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "common/math/elementary.h"
#include "common/random/discrete_distributions.h"
#include "worker/sampling/island_estimate.h"
#include "worker/sampling/log_sum.h"
#include "worker/sampling/metropolis_hastings.h"
#include "worker/sampling/resampling.h"

namespace sleight::sampling {

/// Ordered: a state that passes more stages is nearer, then one with a higher score.
struct Progress {
  std::uint32_t passed = 0;   ///< The first stages, all passed.
  double score = k_log_zero;  ///< Of the next stage; k_log_zero: nothing known.
  /// Number of stages that must be judged to decide whether a state has this progress.
  std::uint32_t stages() const { return passed + (score == k_log_zero ? 0U : 1U); }
  friend auto operator<=>(const Progress&, const Progress&) = default;
};

/// A target with stages. A state satisfies if it passes all of them.
template <class T>
concept PassesStages = ProposesByOutcome<T> && MayFail<T> &&
    requires(const T& target, const typename T::State& state, const typename T::Outcome& outcome,
             std::uint32_t stages) {
  { target.stages() } -> std::same_as<std::uint32_t>;
  /// Progress in the stages that were judged; at most that many are passed.
  { target.progress(outcome) } -> std::same_as<Progress>;
  /// Simulates until the first `stages` stages are judged. `outcome`: of the same state for fewer
  /// stages, or Outcome().
  { target.simulate_stages(state, stages, outcome) } -> std::same_as<typename T::Outcome>;
  /// Like simulate_from, for outcomes of `stages` stages. May stop at the first stage that isn't
  /// passed.
  { target.simulate_from(state, state, outcome, stages) } -> std::same_as<typename T::Outcome>;
};

/// The prior, restricted to the states within a level.
template <PassesStages T>
class WithinLevel {
 public:
  using State = typename T::State;
  using Outcome = typename T::Outcome;

  /// REQUIRES: all but the last of the stages are passed within the level.
  WithinLevel(const T& target, const Progress& least, std::uint32_t stages)
      : target_(target), least_(least), stages_(stages) {}

  State draw_prior(random::Stream& stream) const { return target_.draw_prior(stream); }
  double log_prior(const State& state) const { return target_.log_prior(state); }
  Outcome simulate(const State& state) const { return target_.simulate_stages(state, stages_, {}); }
  Outcome simulate_from(const State& candidate, const State& state, const Outcome& outcome) const {
    return target_.simulate_from(candidate, state, outcome, stages_);
  }
  bool satisfied(const Outcome& outcome) const { return target_.progress(outcome) >= least_; }
  double log_constraint(const Outcome& outcome) const {
    return satisfied(outcome) ? 0 : k_log_zero;
  }
  plan::FailurePointer failure(const Outcome& outcome) const { return target_.failure(outcome); }
  bool starts_overlap(const Outcome& outcome) const { return target_.starts_overlap(outcome); }
  Proposal<State> propose(const State& state, const Outcome& outcome,
                          std::span<const double> scales, random::Stream& stream) const {
    return target_.propose(state, outcome, scales, stream);
  }
  double log_q_ratio(const State& state, const Outcome& outcome, const Proposal<State>& proposal,
                     const Outcome& candidate_outcome) const {
    return target_.log_q_ratio(state, outcome, proposal, candidate_outcome);
  }
  bool has_scale(std::uint32_t kind) const { return target_.has_scale(kind); }
  std::uint32_t proposal_kinds() const { return target_.proposal_kinds(); }

 private:
  const T& target_;
  Progress least_;
  std::uint32_t stages_;
};

struct Level {
  Progress least;
  std::uint32_t moves = 0;  ///< Of each particle, once it is within the level.
  friend bool operator==(const Level&, const Level&) = default;
};

/// Its Z is the integral of p_w p_c over the states that satisfy. Without a draw, P and Z are 0.
template <PassesStages T>
struct SplitIsland {
  IslandEstimate estimate{};
  std::optional<Sample<T>> drawn{};  ///< A last particle, drawn by p_c.
};

/// Makes islands. REQUIRES: the target outlives this object.
template <PassesStages T>
class Splitting {
 public:
  static constexpr double k_kept = 1.0 / 3;  ///< Share of particles that a level keeps.
  // Accepted moves of each particle, on average; if they are fewer than the minimum, the search for
  // levels gives up.
  static constexpr std::uint32_t k_accepted = 3;
  static constexpr double k_accepted_min = 0.25;
  static constexpr std::uint32_t k_moves_max = 30;
  static constexpr std::size_t k_levels_max = 200;

  Splitting(const T& target, std::uint32_t particles, const ChainStreams& streams)
      : target_(target), particles_(particles), streams_(streams) {}

  /// Returns levels, of which the last one has the states that satisfy. If nothing is gained any
  /// more, that level follows at once. `told` receives StepReports of moves and SimulationReports.
  template <class Told>
  std::vector<Level> find_levels(const Told& told) const {
    std::vector<Level> levels;
    const Progress all_passed{.passed = target_.stages()};
    Making making = begun(0, told);
    while (levels.size() < k_levels_max) {
      const Progress last = levels.empty() ? Progress{} : levels.back().least;
      const Progress least = next_level(making, last);
      if (least == last || least == all_passed) break;
      keep(making, least);
      std::uint32_t accepted = 0;
      std::uint32_t moves = 0;
      for (; accepted < k_accepted * particles_ && moves < k_moves_max; ++moves)
        accepted += move(making, least, told);
      levels.push_back({least, moves});
      if (accepted < k_accepted_min * particles_) break;
      if (least.passed == making.stages) extend(making, making.stages + 1, told);
    }
    levels.push_back({all_passed, 0});
    return levels;
  }

  /// Makes the `number`-th island. REQUIRES: `levels` are from find_levels().
  template <class Told>
  SplitIsland<T> island(std::span<const Level> levels, std::uint64_t number,
                        const Told& told) const {
    Making making = begun(number, told);
    double log_satisfied = 0;
    for (const Level& level : levels) {
      if (level.least.stages() > making.stages) extend(making, level.least.stages(), told);
      const std::size_t kept = keep(making, level.least);
      if (kept == 0) return {};
      log_satisfied += math::log(static_cast<double>(kept) / particles_);
      for (std::uint32_t nth = 0; nth < level.moves; ++nth)
        move(making, level.least, told);
    }

    // Draw one by p_c.
    LogSum sum;
    std::vector<double> shares;
    for (Sample<T>& particle : making.particles)
      sum.add(particle.log_constraint = target_.log_constraint(particle.outcome));
    for (const Sample<T>& particle : making.particles)
      shares.push_back(math::exp(particle.log_constraint - sum.log_mean()) / particles_);
    const std::size_t drawn = random::draw_by_share(shares, making.resampling);
    return {.estimate = {.log_z = log_satisfied + sum.log_mean(),
                         .log_satisfied = log_satisfied,
                         .effective_size = sampling::effective_size(shares),
                         .accepted = true},
            .drawn = std::move(making.particles[drawn])};
  }

 private:
  struct Making {
    std::vector<Sample<T>> particles{};
    std::uint32_t stages = 1;  ///< That the outcomes judge.
    StepStreams steps;
    random::Stream resampling;
  };

  WithinLevel<T> within(const Making& making, const Progress& least) const {
    return {target_, least, making.stages};
  }

  template <class Told>
  Making begun(std::uint64_t number, const Told& told) const {
    Making making{.steps = step_streams(streams_, number),
                  .resampling = streams_.at(random::Purpose::resampling, number)};
    for (std::uint32_t n = 0; n < particles_; ++n) {
      const auto drawn = draw_afresh(within(making, {}), streams_, number * particles_ + n, told);
      making.particles.push_back({drawn.state, drawn.outcome, drawn.log_prior, 0});
    }
    return making;
  }

  /// Returns the level that keeps k_kept of the particles, or if that isn't beyond `last`, the next
  /// level that a particle has reached, or `last`.
  Progress next_level(const Making& making, const Progress& last) const {
    std::vector<Progress> progress;
    for (const Sample<T>& particle : making.particles)
      progress.push_back(target_.progress(particle.outcome));
    std::ranges::sort(progress, std::greater{});
    const Progress next = progress[static_cast<std::size_t>(k_kept * (particles_ - 1))];
    if (next > last) return next;
    const auto end = std::ranges::lower_bound(progress, last, std::greater{});
    return end == progress.begin() ? last : *std::prev(end);
  }

  /// Judges more stages.
  template <class Told>
  void extend(Making& making, std::uint32_t stages, const Told& told) const {
    making.stages = stages;
    for (Sample<T>& particle : making.particles) {
      particle.outcome = target_.simulate_stages(particle.state, stages, particle.outcome);
      told(report_of(target_, particle.outcome));
    }
  }

  /// Resamples the particles within the level, and returns how many there were.
  std::size_t keep(Making& making, const Progress& least) const {
    std::vector<double> shares;
    for (const Sample<T>& particle : making.particles)
      shares.push_back(target_.progress(particle.outcome) >= least ? 1 : 0);
    const auto kept = static_cast<std::size_t>(std::ranges::count(shares, 1.0));
    if (kept == 0) return 0;
    for (double& share : shares)
      share /= static_cast<double>(kept);
    std::vector<Sample<T>> particles;
    for (const std::uint32_t ancestor : resampled(shares, making.resampling))
      particles.push_back(making.particles[ancestor]);
    making.particles = std::move(particles);
    return kept;
  }

  /// Moves each particle once, and returns how many moves were accepted.
  template <class Told>
  std::uint32_t move(Making& making, const Progress& least, const Told& told) const {
    const WithinLevel<T> target = within(making, least);
    std::uint32_t accepted = 0;
    for (Sample<T>& particle : making.particles) {
      Sample<WithinLevel<T>> current{std::move(particle.state), std::move(particle.outcome),
                                     particle.log_prior, 0};
      const StepReport step = metropolis_hastings_step(target, 1, making.steps, current);
      told(step);
      accepted += step.accepted ? 1U : 0U;
      particle = {std::move(current.state), std::move(current.outcome), current.log_prior, 0};
    }
    return accepted;
  }

  const T& target_;
  std::uint32_t particles_;
  ChainStreams streams_;
};

}  // namespace sleight::sampling
