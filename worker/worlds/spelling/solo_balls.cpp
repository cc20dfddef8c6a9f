#include "worker/worlds/spelling/solo_balls.h"

#include <limits>

#include "worker/worlds/spelling/spelling.h"

namespace sleight::worlds::spelling {

bool SoloBalls::leaves_anchored(const State& state) const {
  for (std::size_t ball = 0; ball < anchor_.bins.size(); ++ball) {
    if (anchor_.bins[ball] == k_fills_none) continue;
    if (state.active[ball] == 0 || state.drops_m[ball] != anchor_.drops_m[ball]) return false;
  }
  return true;
}

void SoloBalls::settle(Outcome& outcome) const {
  std::vector<std::uint8_t> full(world_->balls(), 0);
  outcome.filled = 0;
  outcome.filling.assign(outcome.alone.size(), k_fills_none);
  const auto fill = [&](std::size_t ball, std::int16_t bin) {
    if (bin == k_fills_none || full[static_cast<std::size_t>(bin)] != 0) return;
    full[static_cast<std::size_t>(bin)] = 1;
    outcome.filling[ball] = bin;
    ++outcome.filled;
  };
  for (std::size_t ball = 0; ball < anchor_.bins.size(); ++ball)
    fill(ball, anchor_.bins[ball]);
  for (std::size_t ball = 0; ball < outcome.alone.size(); ++ball) {
    if (anchor_.bins.empty() || anchor_.bins[ball] == k_fills_none) fill(ball, outcome.alone[ball]);
  }
}

State SoloBalls::draw_prior(random::Stream& stream) const {
  return world_->draw_prior(stream);
}

double SoloBalls::log_prior(const State& state) const {
  return world_->log_prior(state);
}

SoloBalls::Outcome SoloBalls::simulate(const State& state) const {
  const State none{.offsets_m = {},
                   .active = std::vector<std::uint8_t>(state.active.size(), 0),
                   .drops_m = std::vector<Vec2>(state.active.size(), Vec2(0, 0))};
  return simulate_from(state, none, {});
}

SoloBalls::Outcome SoloBalls::simulate_from(const State& state, const State& from,
                                            const Outcome& of_from) const {
  const auto impossible = [&] {
    const Filling none(state.active.size(), k_fills_none);
    return Outcome{.possible = false, .alone = none, .filling = none};
  };
  if (!leaves_anchored(state)) return impossible();
  const bool same_box = state.offsets_m == from.offsets_m && of_from.possible;
  const auto same = [&](std::size_t ball) {
    return from.active[ball] == state.active[ball] && from.drops_m[ball] == state.drops_m[ball];
  };
  Outcome outcome{.alone = Filling(state.active.size(), k_fills_none)};
  for (std::size_t ball = 0; ball < state.active.size(); ++ball) {
    if (state.active[ball] == 0) continue;
    if (same_box && same(ball)) {
      outcome.alone[ball] = of_from.alone[ball];
      continue;
    }
    Spelling::Alone alone = world_->fall_alone(state.offsets_m, state.drops_m[ball]);
    if (!alone.possible) return impossible();
    outcome.alone[ball] = alone.bin;
    if (!outcome.failure) outcome.failure = std::move(alone.failure);
  }
  settle(outcome);
  return outcome;
}

double SoloBalls::log_constraint(const Outcome& outcome) const {
  if (!outcome.possible) return -std::numeric_limits<double>::infinity();
  return outcome.filled * world_->parameters().constraint.log_lambda;
}

double SoloBalls::log_constraint_at_most(const State& state) const {
  return world_->log_constraint_at_most(state);
}

bool SoloBalls::satisfied(const Outcome& outcome) const {
  return outcome.possible && outcome.filled == world_->balls();
}

sampling::Proposal<State> SoloBalls::propose(const State& state, const Outcome& outcome,
                                             std::span<const double> scales,
                                             random::Stream& stream) const {
  return world_->propose(state, outcome.possible ? &outcome.filling : nullptr, scales, stream);
}

double SoloBalls::log_q_ratio(const State& state, const Outcome& outcome,
                              const sampling::Proposal<State>& proposal,
                              const Outcome& candidate_outcome) const {
  const auto filling_of = [](const Outcome& of) { return of.possible ? &of.filling : nullptr; };
  return world_->log_q_ratio(state, filling_of(outcome), proposal, filling_of(candidate_outcome));
}

bool SoloBalls::has_scale(std::uint32_t kind) const {
  return world_->has_scale(kind);
}

std::uint32_t SoloBalls::proposal_kinds() const {
  return world_->proposal_kinds();
}

}  // namespace sleight::worlds::spelling
