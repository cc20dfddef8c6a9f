#include "worker/worlds/spelling/pouring_builder.h"

#include <utility>

#include "common/random/discrete_distributions.h"

namespace sleight::worlds::spelling {

Pouring no_balls(const Spelling& world, std::vector<Vec3> offsets_m) {
  State state{.offsets_m = std::move(offsets_m),
              .active = std::vector<std::uint8_t>(world.balls(), 0),
              .drops_m = std::vector<Vec2>(world.balls(), Vec2(0, 0))};
  Outcome outcome = world.simulate(state);
  return {.state = std::move(state), .outcome = std::move(outcome)};
}

Pouring with_ball(const Spelling& world, const Pouring& pouring, std::size_t ball,
                  const Vec2& drop_m) {
  State state = pouring.state;
  state.active[ball] = 1;
  state.drops_m[ball] = drop_m;
  Outcome outcome = world.simulate_from(state, pouring.state, pouring.outcome);
  return {.state = std::move(state), .outcome = std::move(outcome)};
}

Pouring PouringBuilder::start(random::Stream& stream) const {
  return no_balls(*world_, world_->draw_prior(stream).offsets_m);
}

std::optional<Vec2> PouringBuilder::promising_drop(const Pouring& prefix,
                                                   sampling::SearchEffort& effort,
                                                   random::Stream& stream) const {
  const Filling& filling = prefix.outcome.filling;
  const std::vector<std::uint8_t> full = full_bins(stages(), filling);
  const std::vector<std::size_t> empty = empty_bins(stages(), filling);
  for (std::uint32_t turn = 0; turn < k_lone_tries_max; ++turn) {
    // Draw a drop for one of the empty bins.
    const std::size_t bin = empty[random::UniformInteger{.count = empty.size()}.draw(stream)];
    const Vec2 drop_m = drops_.draw(bin, stream);
    if (!world_->prior().may_drop_at(drop_m)) continue;

    // If a ball is dropped above a full bin, it hits the ball in that bin.
    if (is_full(full, world_->number_below(drop_m))) continue;

    const Spelling::Alone alone = world_->fall_alone(prefix.state.offsets_m, drop_m);
    ++effort.guesses;
    if (alone.failure != nullptr) effort.failures.push_back(alone.failure);
    if (alone.bin != k_fills_none && !is_full(full, alone.bin)) return drop_m;
  }
  return std::nullopt;
}

std::optional<Pouring> PouringBuilder::attempt(const Pouring& prefix, std::uint32_t stage,
                                               sampling::SearchEffort& effort,
                                               random::Stream& stream) const {
  const std::optional<Vec2> drop_m = promising_drop(prefix, effort, stream);
  if (!drop_m) return std::nullopt;
  Pouring longer = with_ball(*world_, prefix, stage, *drop_m);
  ++effort.simulations;
  if (world_->starts_overlap(longer.outcome)) ++effort.overlapping_starts;
  if (longer.outcome.failure != nullptr) effort.failures.push_back(longer.outcome.failure);
  if (!longer.outcome.is_animation() || longer.outcome.elsewhere > 0) return std::nullopt;
  return longer;
}

}  // namespace sleight::worlds::spelling
