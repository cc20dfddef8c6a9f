#include "worker/worlds/dice/throw_stages.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "common/math/elementary.h"
#include "common/random/discrete_distributions.h"
#include "worker/sampling/log_sum.h"

namespace sleight::worlds::dice {
namespace {

Parameters with_dice(const Parameters& all, std::size_t first, std::size_t count) {
  Parameters some = all;
  const auto begin = all.world.dice.begin() + static_cast<std::ptrdiff_t>(first);
  some.world.dice.assign(begin, begin + static_cast<std::ptrdiff_t>(count));
  some.goals.clear();
  for (Goal goal : all.goals) {
    if (goal.die < first || goal.die >= first + count) continue;
    goal.die -= static_cast<std::uint32_t>(first);
    some.goals.push_back(goal);
  }
  return some;
}

State with_throw(const ThrowGround& ground, const DieThrow& one) {
  return {.table_key = ground.table_key, .overrides = ground.overrides, .dice = {one}};
}

/// log p_c, at least log_floor.
double promise_of(const Dice& world, const Outcome& outcome, double log_floor) {
  return outcome.is_animation() ? std::max(world.log_constraint(outcome), log_floor) : log_floor;
}

}  // namespace

StagedDice::StagedDice(const Parameters& parameters) : Dice(parameters) {
  const std::vector<DieStart>& starts = parameters.world.dice;
  thrown_at_once_ = std::ranges::all_of(
      starts, [&](const DieStart& start) { return start.start_s == starts.front().start_s; });
  for (std::size_t die = 0; die < dice(); ++die) {
    first_.emplace_back(with_dice(parameters, 0, die + 1));
    if (die > 0) alone_.emplace_back(with_dice(parameters, die, 1));
  }
}

std::string StagedDice::stage_name(std::uint32_t stage) const {
  return fmt::format("die {} of {}", stage + 1, stages());
}

ThrowGuide StagedDice::learn(std::uint64_t seed) const {
  ThrowGuide guide;
  for (std::size_t die = 0; die < dice(); ++die) {
    random::Stream stream({.seed = seed, .purpose = random::Purpose::guide}, die);
    const Dice& world = alone(die);
    std::vector<LoneThrow> throws;
    for (std::uint32_t nth = 0; nth < k_throws_of_map; ++nth) {
      const State state = world.draw_prior(stream);
      const ViewedOutcome seen = world.simulate_and_view(state);
      if (seen.outcome.failure) guide.failures.push_back(seen.outcome.failure);
      if (seen.outcome.end != End::settled) continue;
      throws.push_back({.thrown = state.dice.front(), .misses = world.signed_misses(seen.views)});
    }
    guide.maps.emplace_back(parameters().world.dice[die], throws);
  }
  return guide;
}

std::vector<sampling::BurnInValue> StagedDice::burn_in_values() const {
  return {{.name = "log_prior"}, {.name = "log_constraint"}, {.name = "collisions"}};
}

std::vector<double> StagedDice::burn_in_values_of(const State& state,
                                                  const Outcome& outcome) const {
  return {log_prior(state), log_constraint(outcome), static_cast<double>(outcome.collisions)};
}

ThrowGround StagedDice::ground_of(const Guide& guide, State table, const State* given,
                                  random::Stream& stream) const {
  Ground ground{.table_key = table.table_key, .overrides = std::move(table.overrides), .pools = {}};
  for (std::size_t die = 0; die < dice(); ++die) {
    const ThrowMap& map = guide.maps[die];
    ThrowPool& pool = ground.pools.emplace_back();
    sampling::LogSum sum;
    for (std::uint32_t place = 0; place < guide.throws_of_pool; ++place) {
      const bool is_given = given != nullptr && place == 0;
      const DieThrow one = is_given ? given->dice[die] : map.draw(stream);
      Outcome outcome = alone(die).simulate(with_throw(ground, one));
      ground.simulations.push_back(sampling::report_of(alone(die), outcome));
      const double v = map.prior_over_q(one);
      const double log_guess = promise_of(alone(die), outcome, guide.log_floor);
      pool.throws.push_back({.thrown = one, .v = v, .log_guess = log_guess});
      sum.add(v > 0 ? math::log(v) + log_guess : sampling::k_log_zero);
      if (die == 0) ground.first_die_alone.push_back(std::move(outcome));
    }
    pool.log_sum = sum.log_sum();
    for (const PoolThrow& one : pool.throws)
      pool.shares.push_back(one.v * math::exp(one.log_guess));
  }
  return ground;
}

ThrowGround StagedDice::draw_ground(const Guide& guide, random::Stream& stream) const {
  return ground_of(guide, {.table_key = stream.bits()}, nullptr, stream);
}

ThrowGround StagedDice::ground_given(const Guide& guide, const State& state,
                                     random::Stream& stream) const {
  return ground_of(guide, {.table_key = state.table_key, .overrides = state.overrides}, &state,
                   stream);
}

ThrowPrefix StagedDice::no_stages(const Guide& /*guide*/, const Ground& ground) const {
  return {.state = {.table_key = ground.table_key, .overrides = ground.overrides}};
}

sampling::Extension StagedDice::add(const Ground& ground, std::uint32_t stage, std::size_t place,
                                    Prefix& prefix) const {
  const ThrowPool& pool = ground.pools[stage];
  const PoolThrow& one = pool.throws[place];
  prefix.state.dice.push_back(one.thrown);
  sampling::Extension extension{.log_weight = sampling::k_log_zero};
  if (stage == 0) {
    // The pool already has this outcome, and has reported its failure.
    prefix.outcome = ground.first_die_alone[place];
  } else {
    prefix.outcome = first(stage + 1).simulate(prefix.state);
    extension.simulation = sampling::report_of(first(stage + 1), prefix.outcome);
  }
  // If all dice are thrown at once, dice that overlap also overlap after further dice are added. If
  // a die is thrown later, another die may first push away the die that it would overlap.
  const bool is_last = stage + 1 == stages();
  if (!prefix.outcome.is_animation() && (is_last || thrown_at_once_)) return extension;
  extension.log_weight =
      pool.log_sum - math::log(static_cast<double>(pool.throws.size())) - one.log_guess;
  return extension;
}

sampling::Extension StagedDice::extend(const Guide& /*guide*/, const Ground& ground,
                                       std::uint32_t stage, Prefix& prefix,
                                       random::Stream& stream) const {
  const ThrowPool& pool = ground.pools[stage];
  if (pool.log_sum == sampling::k_log_zero) return {.log_weight = sampling::k_log_zero};
  return add(ground, stage, random::draw_by_share(pool.shares, stream), prefix);
}

sampling::Extension StagedDice::extend_as(const Guide& /*guide*/, const Ground& ground,
                                          const State& /*state*/, std::uint32_t stage,
                                          Prefix& prefix) const {
  return add(ground, stage, 0, prefix);
}

double StagedDice::log_potential(const Guide& guide, const Ground& /*ground*/,
                                 const Prefix& prefix) const {
  return promise_of(first(prefix.state.dice.size()), prefix.outcome, guide.log_floor);
}

}  // namespace sleight::worlds::dice
