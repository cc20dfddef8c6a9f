#include "worker/worlds/user_scene/moves.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/math/elementary.h"
#include "common/random/discrete_distributions.h"
#include "common/random/linear_distributions.h"

namespace sleight::worlds::user_scene {
namespace {

constexpr random::Normal k_normal{.mean = 0, .sd = 1};
/// Share of the tails that renew only what no impact has used.
constexpr double k_renewals = 0.2;

std::size_t one_of(std::size_t count, random::Stream& stream) {
  return static_cast<std::size_t>(random::UniformInteger{.count = count}.draw(stream));
}

bool redraws(Kind kind) {
  return kind <= Kind::redraw_draw;
}

/// Calls `act` for each number of a random block: one draw, a body's draws, or all.
template <class Act>
void for_block(const Quantities& quantities, Kind kind, random::Stream& stream, Act act) {
  const std::span<const Draw> draws = quantities.draws();
  const auto act_on = [&](const Draw& draw) {
    for (std::size_t i = 0; i < draw.numbers; ++i)
      act(draw.first_number + i);
  };
  if (draws.empty()) return;
  if (kind == Kind::redraw_draw || kind == Kind::step_draw)
    return act_on(draws[one_of(draws.size(), stream)]);
  if (kind == Kind::redraw_all || kind == Kind::step_all) {
    for (const Draw& draw : draws)
      act_on(draw);
    return;
  }
  const auto& of_bodies = quantities.draws_of_bodies();
  if (of_bodies.empty()) return;
  for (const std::size_t draw : of_bodies[one_of(of_bodies.size(), stream)])
    act_on(draws[draw]);
}

void change_block(const Quantities& quantities, Kind kind, double step, Numbers& numbers,
                  random::Stream& stream) {
  const double keep = std::sqrt(1 - step * step);
  for_block(quantities, kind, stream, [&](std::size_t i) {
    double& number = numbers[i];
    if (!quantities.is_normal(i) && redraws(kind)) {
      number = stream.uniform();
      return;
    }
    const double normal = k_normal.draw(stream);
    if (quantities.is_normal(i)) {
      number = redraws(kind) ? normal : keep * number + step * normal;
      return;
    }
    // Reflect at 0 and 1.
    double along = number + 0.5 * step * normal;
    along -= 2 * std::floor(0.5 * along);
    along = along > 1 ? 2 - along : along;
    if (along > 0 && along < 1) number = along;
  });
}

}  // namespace

double random_step(double scale, random::Stream& stream) {
  constexpr double k_step = 0.5;
  constexpr std::uint64_t k_halvings = 5;
  const auto halvings = static_cast<int>(one_of(k_halvings + 1, stream));
  return std::min(1.0, std::ldexp(k_step * scale, -halvings));
}

void step_noise(NoiseState& noise, const physics::NoiseAddress& address, double step,
                random::Stream& stream) {
  physics::NoiseValue value = noise.at(address);
  for (double& part : value)
    part = std::sqrt(1 - step * step) * part + step * k_normal.draw(stream);
  noise.set(address, value);
}

NoiseState with_fresh_tail(const NoiseState& noise, std::span<const physics::Impact> noised,
                           physics::Tick from, random::Stream& stream) {
  const auto end = std::ranges::lower_bound(noised, from, {}, &physics::Impact::tick);
  return noise.with_key(stream.bits(), {noised.begin(), end});
}

sampling::Proposal<State> propose(const MoveChoices& choices, const State& state,
                                  std::span<const double> scales, random::Stream& stream) {
  constexpr std::array k_without_noise{0.02, 0.08, 0.1, 0.1, 0.3, 0.4};
  constexpr std::array k_with_noise{0.01, 0.03, 0.04, 0.04, 0.13, 0.15, 0.5, 0.1};
  const auto kind =
      static_cast<Kind>(choices.has_noise ? random::draw_by_share(k_with_noise, stream)
                                          : random::draw_by_share(k_without_noise, stream));
  const double scale = scales.empty() ? 1 : scales[static_cast<std::size_t>(kind)];
  const double step = random_step(scale, stream);
  sampling::Proposal<State> proposal{.candidate = state, .kind = static_cast<std::uint32_t>(kind)};
  State& candidate = proposal.candidate;
  double shot_bound = 0;
  if (kind == Kind::shot) {
    if (choices.noised.empty()) return proposal;
    const std::size_t place = one_of(choices.noised.size(), stream);
    step_noise(candidate.noise, address_of(choices.noised[place]), step, stream);
    // The candidate has at least the impacts up to this one.
    shot_bound =
        math::log(static_cast<double>(choices.noised.size()) / static_cast<double>(place + 1));
    proposal.ratio_waits = true;
  } else if (kind == Kind::tail) {
    const bool renews = stream.uniform() < k_renewals;
    const double from_s = renews ? choices.end_s + 1 : choices.end_s * stream.uniform();
    candidate.noise = with_fresh_tail(state.noise, choices.noised,
                                      physics::Tick{} + physics::ticks_after(from_s), stream);
  } else {
    change_block(choices.quantities, kind, step, candidate.numbers, stream);
    if (kind == Kind::redraw_all && choices.has_noise)
      candidate.noise = {.key = stream.bits(), .overrides = {}};
  }
  // Every move leaves the prior invariant, but for a shot's choice of the impact.
  proposal.log_q_ratio = log_density(choices.quantities, state) -
                         log_density(choices.quantities, candidate) + shot_bound;
  return proposal;
}

double shot_log_ratio(std::span<const physics::Impact> noised,
                      std::span<const physics::Impact> candidate_noised) {
  return math::log(static_cast<double>(noised.size()) /
                   static_cast<double>(candidate_noised.size()));
}

}  // namespace sleight::worlds::user_scene
