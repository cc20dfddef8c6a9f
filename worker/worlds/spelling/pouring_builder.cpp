#include "worker/worlds/spelling/pouring_builder.h"

#include <cmath>
#include <utility>
#include <vector>

#include "common/random/discrete_distributions.h"

namespace sleight::worlds::spelling {

PouringBuilder::Prefix PouringBuilder::start(random::Stream& stream) const {
  State state = world_->draw_prior(stream);
  state.active.assign(world_->balls(), 0);
  state.drops_m.assign(world_->balls(), Vec2(0, 0));
  Outcome outcome = world_->simulate(state);
  return {.state = std::move(state), .outcome = std::move(outcome)};
}

std::optional<Vec2> PouringBuilder::promising_drop(const Prefix& prefix,
                                                   sampling::SearchEffort& effort,
                                                   random::Stream& stream) const {
  std::vector<std::uint8_t> is_full(world_->balls(), 0);
  for (const std::int16_t bin : prefix.outcome.filling)
    if (bin != k_fills_none) is_full[static_cast<std::size_t>(bin)] = 1;
  std::vector<std::size_t> empty;
  for (std::size_t bin = 0; bin < is_full.size(); ++bin)
    if (is_full[bin] == 0) empty.push_back(bin);

  const Vec2& half_m = world_->prior().drop_half_m;
  for (std::uint32_t turn = 0; turn < k_lone_tries_max; ++turn) {
    // Draw a drop for one of the empty bins.
    const std::size_t bin = empty[random::UniformInteger{.count = empty.size()}.draw(stream)];
    const Vec2 drop_m = stream.uniform() < k_window_share
                            ? world_->windows().draw(bin, stream)
                            : Vec2(world_->middle_m(bin) + map_->draw(stream));
    if (std::abs(drop_m.x()) > half_m.x() || std::abs(drop_m.y()) > half_m.y()) continue;

    // A ball above a full bin would hit the ball in it.
    const std::int16_t below = world_->number_below(drop_m);
    if (below != k_fills_none && is_full[static_cast<std::size_t>(below)] != 0) continue;

    // Alone it must fill an empty bin.
    const Spelling::Alone alone = world_->fall_alone(prefix.state.offsets_m, drop_m);
    ++effort.guesses;
    if (alone.failure != nullptr) effort.failures.push_back(alone.failure);
    if (alone.bin != k_fills_none && is_full[static_cast<std::size_t>(alone.bin)] == 0)
      return drop_m;
  }
  return std::nullopt;
}

std::optional<PouringBuilder::Prefix> PouringBuilder::attempt(const Prefix& prefix,
                                                              std::uint32_t stage,
                                                              sampling::SearchEffort& effort,
                                                              random::Stream& stream) const {
  const std::optional<Vec2> drop_m = promising_drop(prefix, effort, stream);
  if (!drop_m) return std::nullopt;

  // Drop it among those that stand.
  State state = prefix.state;
  state.active[stage] = 1;
  state.drops_m[stage] = *drop_m;
  Outcome outcome = world_->simulate_from(state, prefix.state, prefix.outcome);
  ++effort.simulations;
  if (world_->starts_overlap(outcome)) ++effort.overlapping_starts;
  if (outcome.failure != nullptr) effort.failures.push_back(outcome.failure);
  if (!outcome.is_animation() || outcome.elsewhere > 0) return std::nullopt;
  return Prefix{.state = std::move(state), .outcome = std::move(outcome)};
}

}  // namespace sleight::worlds::spelling
