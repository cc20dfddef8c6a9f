#include "worker/worlds/spelling/pouring_stages.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/check.h"
#include "common/math/elementary.h"
#include "common/random/discrete_distributions.h"
#include "worker/sampling/log_sum.h"

namespace sleight::worlds::spelling {
namespace {

/// Landings of a bin in the pool weigh as so many more that are as common as in the mean: a bin
/// that no drop of the pool fills alone gets a share above 0.
constexpr double k_drops_of_the_mean = 3;
/// The least mean share, for pools without any landing.
constexpr double k_mean_share_min = 1e-5;

}  // namespace

std::uint32_t StagedSpelling::drops_per_bin(const Guide& guide) const {
  return std::max(guide.drops_per_bin, balls());
}

bool StagedSpelling::is_dropped_from(const Vec2& drop_m) const {
  const Vec2& half_m = prior().drop_half_m;
  return std::abs(drop_m.x()) <= half_m.x() && std::abs(drop_m.y()) <= half_m.y();
}

Vec2 StagedSpelling::draw_of_stratum(const Guide& guide, std::size_t bin,
                                     random::Stream& stream) const {
  if (stream.uniform() < guide.prior_share) {
    const Vec2& half_m = prior().drop_half_m;
    const double x_m = half_m.x() * (2 * stream.uniform() - 1);
    const double y_m = half_m.y() * (2 * stream.uniform() - 1);
    return {x_m, y_m};
  }
  if (stream.uniform() < guide.window_share) return windows().draw(bin, stream);
  return middle_m(bin) + guide.map.draw(stream);
}

double StagedSpelling::density_of_stratum(const Guide& guide, std::size_t bin,
                                          const Vec2& drop_m) const {
  const double of_prior = math::exp(-prior().log_area());
  const double of_window = windows().density(std::span(&bin, 1), drop_m);
  const double of_map = guide.map.density(drop_m - middle_m(bin));
  return guide.prior_share * of_prior +
         (1 - guide.prior_share) *
             (guide.window_share * of_window + (1 - guide.window_share) * of_map);
}

PoolDrop StagedSpelling::looked_at(const Guide& guide, std::span<const Vec3> offsets_m,
                                   const Vec2& drop_m) const {
  PoolDrop drop{.drop_m = drop_m};
  if (!is_dropped_from(drop_m)) return drop;
  double sum = 0;
  for (std::size_t bin = 0; bin < balls(); ++bin)
    sum += density_of_stratum(guide, bin, drop_m);
  drop.v = math::exp(-prior().log_area()) * balls() / sum;
  // What fails alone fills none: a guess.
  drop.alone = fall_alone(offsets_m, drop_m).bin;
  drop.below = number_below(drop_m);
  return drop;
}

void StagedSpelling::fill_pool(const Guide& guide, std::span<const std::uint8_t> is_retained,
                               random::Stream& stream, Ground& ground) const {
  const std::uint32_t n = drops_per_bin(guide);
  for (std::uint32_t place = 0; place < ground.pool.size(); ++place) {
    const Vec2 drop_m = is_retained[place] != 0 ? ground.pool[place].drop_m
                                                : draw_of_stratum(guide, place / n, stream);
    ground.pool[place] = looked_at(guide, ground.offsets_m, drop_m);
  }

  // How common it is that a drop of the prior fills a bin alone.
  std::vector<double> landings(balls(), 0);
  for (const PoolDrop& drop : ground.pool)
    if (drop.alone != k_fills_none) landings[static_cast<std::size_t>(drop.alone)] += drop.v;
  const auto size = static_cast<double>(ground.pool.size());
  double sum = 0;
  for (const double landing : landings)
    sum += landing / size;
  ground.mean_share = std::max(sum / balls(), k_mean_share_min);
  for (const double landing : landings) {
    ground.bin_share.push_back((landing / size * n + ground.mean_share * k_drops_of_the_mean) /
                               (n + k_drops_of_the_mean));
  }
}

PouringGround StagedSpelling::draw_ground(const Guide& guide, random::Stream& stream) const {
  const std::size_t size = std::size_t{drops_per_bin(guide)} * balls();
  Ground ground{.offsets_m = draw_prior(stream).offsets_m,
                .pool = std::vector<PoolDrop>(size),
                .retained = std::vector<std::uint32_t>(balls(), k_no_drop)};
  fill_pool(guide, std::vector<std::uint8_t>(size, 0), stream, ground);
  return ground;
}

PouringGround StagedSpelling::ground_given(const Guide& guide, const State& state,
                                           random::Stream& stream) const {
  const std::uint32_t n = drops_per_bin(guide);
  const std::size_t size = std::size_t{n} * balls();
  Ground ground{.offsets_m = state.offsets_m,
                .pool = std::vector<PoolDrop>(size),
                .retained = std::vector<std::uint32_t>(balls(), k_no_drop)};

  // Put each ball's drop in an unused place of a stratum that may have given it.
  std::vector<std::uint8_t> is_retained(size, 0);
  std::vector<std::uint32_t> used_of_bin(balls(), 0);
  std::vector<double> densities(balls());
  for (std::size_t ball = 0; ball < balls(); ++ball) {
    if (state.active[ball] == 0) continue;
    const Vec2& drop_m = state.drops_m[ball];
    for (std::size_t bin = 0; bin < balls(); ++bin)
      densities[bin] = density_of_stratum(guide, bin, drop_m);
    const std::size_t bin = random::draw_by_share(densities, stream);
    std::uint64_t nth = random::UniformInteger{.count = n - used_of_bin[bin]}.draw(stream);
    std::size_t place = bin * n;
    while (is_retained[place] != 0 || nth-- > 0)
      ++place;
    is_retained[place] = 1;
    ++used_of_bin[bin];
    ground.pool[place].drop_m = drop_m;
    ground.retained[ball] = static_cast<std::uint32_t>(place);
  }
  fill_pool(guide, is_retained, stream, ground);
  return ground;
}

PouringPrefix StagedSpelling::no_stages(const Guide& /*guide*/, const Ground& ground) const {
  State state{.offsets_m = ground.offsets_m,
              .active = std::vector<std::uint8_t>(balls(), 0),
              .drops_m = std::vector<Vec2>(balls(), Vec2(0, 0))};
  Outcome outcome = simulate(state);
  return {.state = std::move(state),
          .outcome = std::move(outcome),
          .is_used = std::vector<std::uint8_t>(ground.pool.size(), 0),
          .used_of_bin = std::vector<std::uint32_t>(balls(), 0)};
}

std::vector<double> StagedSpelling::guesses(const Guide& guide, const Ground& ground,
                                            const Prefix& prefix) const {
  std::vector<std::uint8_t> is_full(balls(), 0);
  for (const std::int16_t bin : prefix.outcome.filling)
    if (bin != k_fills_none) is_full[static_cast<std::size_t>(bin)] = 1;
  const auto full = [&](std::int16_t bin) {
    return bin != k_fills_none && is_full[static_cast<std::size_t>(bin)] != 0;
  };
  std::vector<double> guesses;
  guesses.reserve(ground.pool.size());
  for (std::size_t place = 0; place < ground.pool.size(); ++place) {
    const PoolDrop& drop = ground.pool[place];
    if (prefix.is_used[place] != 0 || drop.v == 0) {
      guesses.push_back(0);
    } else if (drop.alone == k_fills_none || full(drop.alone)) {
      guesses.push_back(guide.odds.other / ground.mean_share);
    } else {
      const double odds = full(drop.below)           ? guide.odds.above_full
                          : drop.below == drop.alone ? guide.odds.own_bin
                                                     : guide.odds.beside;
      guesses.push_back(odds / ground.bin_share[static_cast<std::size_t>(drop.alone)]);
    }
  }
  return guesses;
}

sampling::Extension StagedSpelling::extend_by(const Guide& guide, const Ground& ground,
                                              std::uint32_t stage, std::uint32_t drop,
                                              std::span<const double> guesses,
                                              Prefix& prefix) const {
  if (drop == k_no_drop) return {.log_weight = math::log(0.5 / (1 - guide.takes_part))};

  // Weigh the choice.
  const std::uint32_t n = drops_per_bin(guide);
  double sum = 0;
  for (std::size_t place = 0; place < ground.pool.size(); ++place) {
    const std::uint32_t used = prefix.used_of_bin[place / n];
    if (guesses[place] > 0) sum += ground.pool[place].v * guesses[place] * n / double(n - used);
  }
  const double log_weight = math::log(0.5 / guide.takes_part) +
                            math::log(sum / static_cast<double>(ground.pool.size())) -
                            math::log(guesses[drop]);

  // Drop the ball among those before it.
  State state = prefix.state;
  state.active[stage] = 1;
  state.drops_m[stage] = ground.pool[drop].drop_m;
  Outcome outcome = simulate_from(state, prefix.state, prefix.outcome);
  const sampling::SimulationReport report{.starts_overlap = starts_overlap(outcome),
                                          .failure = failure(outcome)};
  if (!outcome.is_animation()) return {.log_weight = sampling::k_log_zero, .simulation = report};
  prefix.state = std::move(state);
  prefix.outcome = std::move(outcome);
  prefix.is_used[drop] = 1;
  ++prefix.used_of_bin[drop / n];
  return {.log_weight = log_weight, .simulation = report};
}

sampling::Extension StagedSpelling::extend(const Guide& guide, const Ground& ground,
                                           std::uint32_t stage, Prefix& prefix,
                                           random::Stream& stream) const {
  if (stream.uniform() >= guide.takes_part)
    return extend_by(guide, ground, stage, k_no_drop, {}, prefix);
  const std::vector<double> g = guesses(guide, ground, prefix);
  const std::uint32_t n = drops_per_bin(guide);
  std::vector<double> shares;
  shares.reserve(g.size());
  double sum = 0;
  for (std::size_t place = 0; place < g.size(); ++place) {
    const std::uint32_t used = prefix.used_of_bin[place / n];
    sum += shares.emplace_back(ground.pool[place].v * g[place] * n / double(n - used));
  }
  if (!(sum > 0)) return {.log_weight = sampling::k_log_zero};
  const auto drop = static_cast<std::uint32_t>(random::draw_by_share(shares, stream));
  return extend_by(guide, ground, stage, drop, g, prefix);
}

sampling::Extension StagedSpelling::extend_as(const Guide& guide, const Ground& ground,
                                              const State& state, std::uint32_t stage,
                                              Prefix& prefix) const {
  if (state.active[stage] == 0) return extend_by(guide, ground, stage, k_no_drop, {}, prefix);
  const std::vector<double> g = guesses(guide, ground, prefix);
  return extend_by(guide, ground, stage, ground.retained[stage], g, prefix);
}

double StagedSpelling::log_potential(const Guide& guide, const Ground& ground,
                                     const Prefix& prefix) const {
  // 0 * -infinity is NaN.
  double log_potential =
      prefix.outcome.elsewhere == 0 ? 0 : prefix.outcome.elsewhere * guide.log_elsewhere;
  for (const std::int16_t bin : prefix.outcome.filling) {
    if (bin == k_fills_none) continue;
    const double share = ground.bin_share[static_cast<std::size_t>(bin)];
    log_potential += parameters().constraint.log_lambda - math::log(share);
  }
  return log_potential;
}

}  // namespace sleight::worlds::spelling
