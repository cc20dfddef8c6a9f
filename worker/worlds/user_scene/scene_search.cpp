#include "worker/worlds/user_scene/scene_search.h"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>

#include "common/math/elementary.h"
#include "common/random/discrete_distributions.h"
#include "worker/physics/event/tick.h"
#include "worker/sampling/log_sum.h"

namespace sleight::worlds::user_scene {
namespace {

using Prefix = SceneSearch::Prefix;

constexpr std::uint32_t k_first_draws = 8;
constexpr std::uint32_t k_tails = 8;
constexpr std::uint32_t k_shots = 60;
/// One try in so many walks, because tails mostly succeed at once, or else the prefix is to blame.
constexpr std::uint32_t k_tries_of_walk = 4;

/// One try of a stage.
class Try {
 public:
  Try(const UserScene& world, std::uint32_t stages, sampling::SearchEffort& effort)
      : world_(world), stages_(stages), effort_(effort) {}

  /// Simulates a state. Keeps it if it is better than the best one so far, or if `accepts` is true
  /// for the gain in log p_c. Returns whether it meets the stage's constraints.
  template <class Accepts>
  bool look(State state, const Outcome& earlier, Accepts accepts) {
    Outcome outcome = world_.simulate_stages(state, stages_, earlier);
    ++effort_.simulations;
    if (world_.starts_overlap(outcome)) ++effort_.overlapping_starts;
    if (outcome.failure) effort_.failures.push_back(outcome.failure);
    const double log = world_.log_constraint(outcome);
    const bool met = world_.satisfied(outcome);
    const std::optional<sampling::Miss> miss = world_.first_miss(outcome);
    if (miss) effort_.misses(stages_ - 1, miss->kind, miss->amount);
    if (!met && !is_first_ && !(log > sampling::k_log_zero && accepts(log - best_log_)))
      return false;
    best_ = {std::move(state), std::move(outcome)};
    best_log_ = log;
    is_first_ = false;
    return met;
  }
  bool look_if_better(State state, const Outcome& earlier) {
    return look(std::move(state), earlier, [](double gain) { return gain > 0; });
  }
  /// Anneals: log p_c counts more and more. Returns whether a state met the constraints.
  template <class Change>
  bool walk(std::uint32_t steps, random::Stream& stream, Change change) {
    for (std::uint32_t step = 0; step < steps; ++step) {
      std::optional<State> candidate = change(best_);
      if (!candidate) return false;
      const double log_u = math::log(stream.uniform());
      const double beta = (step + 1.0) / steps;
      const std::shared_ptr<const physics::History> history = best_.outcome.history;
      if (look(*std::move(candidate), {.history = history},
               [&](double gain) { return beta * gain >= log_u; }))
        return true;
    }
    return false;
  }
  Prefix take() { return std::move(best_); }

 private:
  const UserScene& world_;
  std::uint32_t stages_;
  sampling::SearchEffort& effort_;
  Prefix best_;
  double best_log_ = sampling::k_log_zero;
  bool is_first_ = true;
};

}  // namespace

SceneSearch UserScene::builder(const Guide& /*guide*/) const {
  return SceneSearch(*this);
}

std::optional<Prefix> SceneSearch::attempt(const Prefix& prefix, std::uint32_t stage,
                                           sampling::SearchEffort& effort,
                                           random::Stream& stream) const {
  Try attempt(*world_, stage + 1, effort);
  if (stage == 0) {
    for (std::uint32_t nth = 0; nth < k_first_draws; ++nth) {
      if (attempt.look_if_better(world_->draw_prior(stream), {})) return attempt.take();
    }
    const auto steps = static_cast<std::uint32_t>(
        std::clamp<std::size_t>(40 * world_->quantities().draws().size(), 100, 2000));
    // The moves keep the prior, so only p_c decides.
    const auto move = [&](const Prefix& best) {
      return std::optional(world_->propose(best.state, best.outcome, {}, stream).candidate);
    };
    if (attempt.walk(steps, stream, move)) return attempt.take();
    return std::nullopt;
  }

  const physics::Tick decided =
      physics::Tick{} + physics::ticks_after(prefix.outcome.judgement.decided_s);
  const auto free_impacts = [&](const Outcome& outcome) {
    const auto first =
        std::ranges::lower_bound(outcome.noised, decided, {}, &physics::Impact::tick);
    return std::span(first, outcome.noised.end());
  };
  for (std::uint32_t nth = 0; nth < k_tails; ++nth) {
    State state = prefix.state;
    state.noise = with_fresh_tail(state.noise, prefix.outcome.noised, decided, stream);
    if (attempt.look_if_better(std::move(state), prefix.outcome)) return attempt.take();
  }
  if (random::UniformInteger{.count = k_tries_of_walk}.draw(stream) != 0) return std::nullopt;
  const auto shoot = [&](const Prefix& best) -> std::optional<State> {
    const auto impacts = free_impacts(best.outcome);
    if (impacts.empty()) return std::nullopt;
    const auto nth = random::UniformInteger{.count = impacts.size()}.draw(stream);
    State state = best.state;
    step_noise(state.noise, address_of(impacts[nth]), random_step(1, stream), stream);
    return state;
  };
  if (attempt.walk(k_shots, stream, shoot)) return attempt.take();
  return std::nullopt;
}

}  // namespace sleight::worlds::user_scene
