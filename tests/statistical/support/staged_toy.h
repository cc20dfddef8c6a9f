// A world for tests of islands. The world acts in stages, and has few enough states to enumerate.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "common/math/elementary.h"
#include "common/random/discrete_distributions.h"
#include "worker/sampling/stages.h"

namespace sleight::statistical {

/// There are seven places. A walker takes four steps, and has three choices for each step. The
/// walker begins at one of two places, with probabilities 0.4 and 0.6. The walker falls at place 5,
/// and only choice 2 puts it on its feet again. Most states end where p_c is small. A fallen walker
/// has a p_c of 0. About a fifth of the mass belongs to states in which the walker fell on the way
/// and was rescued.
struct StagedToy {
  static constexpr std::uint32_t k_stages = 4;
  static constexpr std::uint32_t k_choices = 3;
  static constexpr std::uint32_t k_states = 2 * 81;
  static constexpr double k_infinity = std::numeric_limits<double>::infinity();

  /// The digits are the ground and the choices: ground * 81 + x_0 * 27 + x_1 * 9 + x_2 * 3 + x_3.
  using State = std::uint32_t;
  struct Outcome {
    std::uint32_t place = 0;
    bool fallen = false;
    bool operator==(const Outcome&) const = default;
  };
  struct Guide {
    /// Choices are drawn from q(x) proportional to p(x)^(1 - flatness).
    double flatness = 0.7;
    /// log psi of a fallen walker. -infinity excludes states in which the walker falls and gets up
    /// again.
    double log_fallen = -2;
  };
  using Ground = std::uint32_t;
  struct Prefix {
    State digits = 0;
    Outcome outcome{};
  };

  static constexpr std::array<double, 2> k_grounds{0.4, 0.6};

  static std::uint32_t ground_of(State state) { return state / 81; }
  static std::uint32_t choice_of(State state, std::uint32_t stage) {
    constexpr std::array<State, k_stages> k_weights{27, 9, 3, 1};
    return state / k_weights[stage] % k_choices;
  }
  static Outcome begin_of(Ground ground) { return {.place = 3 * ground}; }
  /// Returns the probability p of each choice at the walker's place.
  static std::array<double, k_choices> choices(const Outcome& from) {
    if (from.place % 2 == 0) return {0.5, 0.3, 0.2};
    return {0.25, 0.6, 0.15};
  }
  static Outcome step(const Outcome& from, std::uint32_t choice) {
    if (from.fallen) return choice == 2 ? Outcome{.place = 1} : from;
    const std::uint32_t place = (3 * from.place + choice + 1) % 7;
    return {.place = place, .fallen = place == 5};
  }

  State draw_prior(random::Stream& stream) const {
    const Ground ground = stream.uniform() < k_grounds[0] ? 0 : 1;
    Prefix prefix{.digits = ground, .outcome = begin_of(ground)};
    for (std::uint32_t stage = 0; stage < k_stages; ++stage) {
      const auto p = choices(prefix.outcome);
      const auto choice = static_cast<std::uint32_t>(random::draw_by_share(p, stream));
      prefix = {.digits = prefix.digits * k_choices + choice,
                .outcome = step(prefix.outcome, choice)};
    }
    return prefix.digits;
  }
  double log_prior(const State& state) const {
    Outcome outcome = begin_of(ground_of(state));
    double p = k_grounds.at(ground_of(state));
    for (std::uint32_t stage = 0; stage < k_stages; ++stage) {
      p *= choices(outcome).at(choice_of(state, stage));
      outcome = step(outcome, choice_of(state, stage));
    }
    return math::log(p);
  }
  Outcome simulate(const State& state) const {
    Outcome outcome = begin_of(ground_of(state));
    for (std::uint32_t stage = 0; stage < k_stages; ++stage)
      outcome = step(outcome, choice_of(state, stage));
    return outcome;
  }
  double log_constraint(const Outcome& outcome) const {
    constexpr std::array<double, 7> k_log_constraint{-4, -0.2, 0.5, -3, -1, -k_infinity, -5};
    return outcome.fallen ? -k_infinity : k_log_constraint.at(outcome.place);
  }
  bool satisfied(const Outcome& outcome) const {
    return !outcome.fallen && (outcome.place == 1 || outcome.place == 2);
  }
  sampling::Proposal<State> propose(const State& state, random::Stream& stream) const {
    const auto at =
        static_cast<std::uint32_t>(random::UniformInteger{.count = k_stages + 1}.draw(stream));
    const auto by = static_cast<std::uint32_t>(1 + random::UniformInteger{.count = 2}.draw(stream));
    if (at == k_stages) return {.candidate = (state + 81) % k_states};
    State candidate = ground_of(state);
    for (std::uint32_t stage = 0; stage < k_stages; ++stage) {
      const std::uint32_t choice = choice_of(state, stage);
      candidate = candidate * k_choices + (stage == at ? (choice + by) % k_choices : choice);
    }
    return {.candidate = candidate};
  }
  std::uint32_t proposal_kinds() const { return 1; }

  std::uint32_t stages() const { return k_stages; }
  Ground draw_ground(const Guide&, random::Stream& stream) const {
    return stream.uniform() < k_grounds[0] ? 0 : 1;
  }
  Ground ground_given(const Guide&, const State& state, random::Stream&) const {
    return ground_of(state);
  }
  std::span<const sampling::SimulationReport> simulations_of(const Ground&) const { return {}; }
  Prefix no_stages(const Guide&, const Ground& ground) const {
    return {.digits = ground, .outcome = begin_of(ground)};
  }
  static std::array<double, k_choices> guided(const Guide& guide, const Outcome& from) {
    std::array<double, k_choices> q = choices(from);
    double sum = 0;
    for (double& x : q)
      sum += x = math::exp((1 - guide.flatness) * math::log(x));
    for (double& x : q)
      x /= sum;
    return q;
  }
  sampling::Extension extend_by(const Guide& guide, std::uint32_t choice, Prefix& prefix) const {
    const double weight = choices(prefix.outcome)[choice] / guided(guide, prefix.outcome)[choice];
    prefix = {.digits = prefix.digits * k_choices + choice,
              .outcome = step(prefix.outcome, choice)};
    return {.log_weight = math::log(weight)};
  }
  sampling::Extension extend(const Guide& guide, const Ground&, std::uint32_t, Prefix& prefix,
                             random::Stream& stream) const {
    const auto q = guided(guide, prefix.outcome);
    return extend_by(guide, static_cast<std::uint32_t>(random::draw_by_share(q, stream)), prefix);
  }
  sampling::Extension extend_as(const Guide& guide, const Ground&, const State& state,
                                std::uint32_t stage, Prefix& prefix) const {
    return extend_by(guide, choice_of(state, stage), prefix);
  }
  /// Choice 1 has sort 0; choices 0 and 2 have sort 2. No choice has sort 1. The sorts' masses need
  /// not add up to 1.
  static std::size_t sort_of(std::uint32_t choice) { return choice == 1 ? 0 : 2; }
  std::size_t sorts() const { return 3; }
  std::vector<sampling::Alternative> alternatives(const Guide& guide, const Ground&, std::uint32_t,
                                                  const Prefix& prefix, std::size_t sort) const {
    std::vector<sampling::Alternative> all;
    for (std::uint32_t choice = 0; choice < k_choices; ++choice) {
      const double mass = 3 * guided(guide, prefix.outcome)[choice];
      if (sort_of(choice) == sort)
        all.push_back(
            {.number = choice, .mass = mass, .weight = choices(prefix.outcome)[choice] / mass});
    }
    return all;
  }
  std::vector<double> masses(const Guide& guide, const Ground&, std::uint32_t,
                             const Prefix& prefix) const {
    std::vector<double> masses(sorts(), 0);
    for (std::uint32_t choice = 0; choice < k_choices; ++choice)
      masses[sort_of(choice)] += 3 * guided(guide, prefix.outcome)[choice];
    return masses;
  }
  sampling::Extension take(const Guide& guide, const Ground&, std::uint32_t, std::size_t choice,
                           Prefix& prefix) const {
    extend_by(guide, static_cast<std::uint32_t>(choice), prefix);
    return {};
  }
  double log_potential(const Guide& guide, const Ground&, const Prefix& prefix) const {
    constexpr std::array<double, 7> k_log_promise{-1, 0, 0.3, -0.7, 0, 0, -1.2};
    return prefix.outcome.fallen ? guide.log_fallen : k_log_promise.at(prefix.outcome.place);
  }
  State state_of(const Ground&, const Prefix& prefix) const { return prefix.digits; }
  Outcome outcome_of(const Prefix& prefix) const { return prefix.outcome; }

  static bool has_fallen(State state) {
    Outcome outcome = begin_of(ground_of(state));
    for (std::uint32_t stage = 0; stage + 1 < k_stages; ++stage) {
      outcome = step(outcome, choice_of(state, stage));
      if (outcome.fallen) return true;
    }
    return false;
  }
  /// p_w p_c^beta of each state.
  std::vector<double> masses(double beta) const {
    std::vector<double> masses;
    for (State state = 0; state < k_states; ++state)
      masses.push_back(std::exp(
          sampling::tempered_log_density(log_prior(state), log_constraint(simulate(state)), beta)));
    return masses;
  }
};
static_assert(sampling::ListsChoices<StagedToy>);

}  // namespace sleight::statistical
