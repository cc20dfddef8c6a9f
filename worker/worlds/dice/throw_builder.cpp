#include <utility>

#include "common/math/elementary.h"
#include "worker/sampling/log_sum.h"
#include "worker/worlds/dice/throw_stages.h"

namespace sleight::worlds::dice {
namespace {

/// k_draws is the number of draws from the map before the walk; k_walk_steps is the walk's length.
constexpr std::uint32_t k_draws = 8;
constexpr std::uint32_t k_walk_steps = 60;

}  // namespace

ThrowBuilder StagedDice::builder(const Guide& guide) const {
  return ThrowBuilder(*this, guide);
}

ThrowBuilder::ThrowBuilder(const StagedDice& world, const ThrowGuide& guide)
    : world_(&world), guide_(&guide), walk_(world.parameters().proposal) {
  walk_.change_all = 0;
  walk_.change_die = 0;
  walk_.change_start = 1;
  walk_.change_control = 0;
  walk_.change_contact = 0;
}

ThrowPrefix ThrowBuilder::start(random::Stream& stream) const {
  return {.state = {.table_key = stream.bits()}};
}

ThrowBuilder::Lone ThrowBuilder::looked_at(std::size_t die, State state,
                                           sampling::SearchEffort& effort) const {
  const Dice& world = world_->alone(die);
  Lone lone{.state = std::move(state), .log_target = sampling::k_log_zero};
  lone.outcome = world.simulate(lone.state);
  ++effort.guesses;
  if (lone.outcome.failure) effort.failures.push_back(lone.outcome.failure);
  if (lone.outcome.is_animation())
    lone.log_target = world.log_prior(lone.state) + world.log_constraint(lone.outcome);
  return lone;
}

std::optional<ThrowBuilder::Lone> ThrowBuilder::promising_throw(const Prefix& prefix,
                                                                std::size_t die,
                                                                sampling::SearchEffort& effort,
                                                                random::Stream& stream) const {
  const Dice& world = world_->alone(die);
  Parameters one_start = world.parameters();
  one_start.proposal = walk_;
  State state{.table_key = prefix.state.table_key, .overrides = prefix.state.overrides};

  // Throw the die several times from scratch.
  Lone best{.log_target = sampling::k_log_zero};
  for (std::uint32_t nth = 0; nth < k_draws; ++nth) {
    state.dice = {guide_->maps[die].draw(stream)};
    if (!guide_->maps[die].is_plausible(state.dice.front())) continue;
    Lone lone = looked_at(die, state, effort);
    if (world.satisfied(lone.outcome)) return lone;
    if (best.state.dice.empty() || lone.log_target > best.log_target) best = std::move(lone);
  }

  if (best.state.dice.empty()) return std::nullopt;

  // Change the best throw, one component at a time.
  for (std::uint32_t step = 0; step < k_walk_steps; ++step) {
    State changed = propose(one_start, best.state, best.outcome.contacts, {}, stream).candidate;
    if (!guide_->maps[die].is_plausible(changed.dice.front())) continue;
    Lone lone = looked_at(die, std::move(changed), effort);
    if (world.satisfied(lone.outcome)) return lone;
    const double log_u = math::log(stream.uniform());
    if (lone.log_target - best.log_target > log_u) best = std::move(lone);
  }
  return std::nullopt;
}

std::optional<ThrowPrefix> ThrowBuilder::attempt(const Prefix& prefix, std::uint32_t stage,
                                                 sampling::SearchEffort& effort,
                                                 random::Stream& stream) const {
  std::optional<Lone> lone = promising_throw(prefix, stage, effort, stream);
  if (!lone) return std::nullopt;
  ThrowPrefix longer{.state = prefix.state};
  longer.state.dice.push_back(lone->state.dice.front());
  if (stage == 0) {
    longer.outcome = std::move(lone->outcome);
    return longer;
  }
  const Dice& world = world_->first(stage + 1);
  longer.outcome = world.simulate(longer.state);
  ++effort.simulations;
  if (world.starts_overlap(longer.outcome)) ++effort.overlapping_starts;
  if (longer.outcome.failure) effort.failures.push_back(longer.outcome.failure);
  if (!longer.outcome.is_animation() || !world.satisfied(longer.outcome)) return std::nullopt;
  return longer;
}

}  // namespace sleight::worlds::dice
