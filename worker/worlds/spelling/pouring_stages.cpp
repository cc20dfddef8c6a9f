#include "worker/worlds/spelling/pouring_stages.h"

#include <fmt/format.h>

#include <algorithm>
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

/// Which of DropOdds::ByDistance: that of the nearest bin that isn't full.
std::size_t range_of(const PoolDrop& drop, const std::vector<std::uint8_t>& full) {
  for (std::size_t i = 0; i < drop.near.size() && drop.near[i] != k_fills_none; ++i) {
    if (is_full(full, drop.near[i])) continue;
    const float bins = drop.near_bins[i];
    return bins < 1 ? 0 : bins < 1.5F ? 1 : bins < 2.5F ? 2 : 3;
  }
  return 3;
}

double odds_of(const DropOdds& odds, const PoolDrop& drop, const std::vector<std::uint8_t>& full) {
  const bool above_full = is_full(full, drop.below);
  const bool into_full = is_full(full, drop.alone);
  const bool fills = drop.alone != k_fills_none && !into_full;
  if (fills && drop.alone == drop.below) return odds.own_bin;
  const std::size_t range = range_of(drop, full);
  if (fills) return above_full ? odds.above_full[range] : odds.beside[range];
  return above_full || into_full ? odds.meets_full[range] : odds.misses[range];
}

}  // namespace

std::string StagedSpelling::past_effort() const {
  return fmt::format(
      "in proportion takes long: on two cores five of HI (16 balls) took 15 to 40 s, of ACM (30 "
      "balls) 60 to 150 s, of SLEIGHT (61 balls) 250 s, or more than 300 with another seed; this "
      "has {} balls",
      balls());
}

std::string StagedSpelling::stage_name(std::uint32_t stage) const {
  return fmt::format("ball {} of {}", stage + 1, stages());
}

PouringGuide StagedSpelling::learn(std::uint64_t seed) const {
  const Landings landings = landings_of(*this, seed, k_landing_batches);
  return {.map = LandingMap(landings),
          .failures = landings.failures(),
          .takes_part = 1 - std::min(0.02, 0.2 / balls())};
}

std::vector<sampling::BurnInValue> StagedSpelling::burn_in_values() const {
  // A ball alone has nobody to help it.
  return {{.name = "helped_balls", .starts_at_one_end = balls() > 1},
          {.name = "log_prior"},
          {.name = "filled"},
          {.name = "elsewhere"}};
}

std::vector<double> StagedSpelling::burn_in_values_of(const State& state,
                                                      const Outcome& outcome) const {
  return {static_cast<double>(helped_balls(state, outcome)), log_prior(state),
          static_cast<double>(outcome.filled), static_cast<double>(outcome.elsewhere)};
}

std::uint32_t StagedSpelling::helped_balls(const State& state, const Outcome& outcome) const {
  std::uint32_t helped = 0;
  for (std::size_t ball = 0; ball < outcome.filling.size(); ++ball) {
    if (state.active[ball] == 0 || outcome.filling[ball] == k_fills_none) continue;
    if (fall_alone(state.offsets_m, state.drops_m[ball]).bin != outcome.filling[ball]) ++helped;
  }
  return helped;
}

std::uint32_t StagedSpelling::drops_per_bin(const Guide& guide) const {
  return std::max(guide.drops_per_bin, balls());
}

Vec2 StagedSpelling::draw_of_stratum(const Guide& guide, std::size_t bin,
                                     random::Stream& stream) const {
  if (stream.uniform() < guide.prior_share) return prior().draw_drop(stream);
  return BinDrops(*this, guide.map).draw(bin, stream);
}

double StagedSpelling::density_of_stratum(const Guide& guide, std::size_t bin,
                                          const Vec2& drop_m) const {
  return guide.prior_share * math::exp(-prior().log_area()) +
         (1 - guide.prior_share) * BinDrops(*this, guide.map).density(bin, drop_m);
}

PouringGround StagedSpelling::empty_ground(const Guide& guide, std::vector<Vec3> offsets_m) const {
  return {.offsets_m = std::move(offsets_m),
          .pool = std::vector<PoolDrop>(std::size_t{drops_per_bin(guide)} * balls()),
          .retained = std::vector<std::uint32_t>(balls(), k_no_drop)};
}

void StagedSpelling::look_at(const Guide& guide, const Vec2& drop_m, std::size_t place,
                             Ground& ground) const {
  PoolDrop& drop = ground.pool[place];
  drop.drop_m = drop_m;
  if (!prior().may_drop_at(drop_m)) return;
  double sum = 0;
  for (std::size_t bin = 0; bin < balls(); ++bin)
    sum += density_of_stratum(guide, bin, drop_m);
  drop.v = math::exp(-prior().log_area()) * balls() / sum;
  const Alone alone = fall_alone(ground.offsets_m, drop_m);
  if (alone.failure != nullptr) ground.failed.push_back({.failure = alone.failure});
  drop.alone = alone.bin;
  drop.below = number_below(drop_m);
  find_near_bins(drop);
}

void StagedSpelling::find_near_bins(PoolDrop& drop) const {
  std::vector<std::pair<double, std::int16_t>> all;
  for (std::size_t bin = 0; bin < balls(); ++bin) {
    all.emplace_back((middle_m(bin) - drop.drop_m).norm() / bins().pitch_m(),
                     static_cast<std::int16_t>(bin));
  }
  const std::size_t count = std::min(all.size(), drop.near.size());
  std::partial_sort(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count), all.end());
  drop.near.fill(k_fills_none);
  for (std::size_t i = 0; i < count; ++i) {
    drop.near[i] = all[i].second;
    drop.near_bins[i] = static_cast<float>(all[i].first);
  }
}

void StagedSpelling::fill_pool(const Guide& guide, random::Stream& stream, Ground& ground,
                               std::span<const std::uint8_t> is_retained) const {
  const std::uint32_t n = drops_per_bin(guide);
  for (std::size_t place = 0; place < ground.pool.size(); ++place) {
    const bool stays = !is_retained.empty() && is_retained[place] != 0;
    look_at(guide, stays ? ground.pool[place].drop_m : draw_of_stratum(guide, place / n, stream),
            place, ground);
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
  Ground ground = empty_ground(guide, draw_prior(stream).offsets_m);
  fill_pool(guide, stream, ground, {});
  return ground;
}

PouringGround StagedSpelling::ground_given(const Guide& guide, const State& state,
                                           random::Stream& stream) const {
  Ground ground = empty_ground(guide, state.offsets_m);

  // Put each ball's drop in an unused place of a stratum that may have given it.
  const std::uint32_t n = drops_per_bin(guide);
  std::vector<std::uint8_t> is_retained(ground.pool.size(), 0);
  std::vector<std::uint32_t> used_of_bin(balls(), 0);
  std::vector<double> densities(balls());
  for (std::size_t ball = 0; ball < balls(); ++ball) {
    if (state.active[ball] == 0) continue;
    const Vec2& drop_m = state.drops_m[ball];
    for (std::size_t bin = 0; bin < balls(); ++bin)
      densities[bin] = density_of_stratum(guide, bin, drop_m);
    const std::size_t bin = random::draw_by_share(densities, stream);
    std::uint64_t unused_before =
        random::UniformInteger{.count = n - used_of_bin[bin]}.draw(stream);
    std::size_t place = bin * n;
    while (is_retained[place] != 0 || unused_before-- > 0)
      ++place;
    is_retained[place] = 1;
    ++used_of_bin[bin];
    ground.pool[place].drop_m = drop_m;
    ground.retained[ball] = static_cast<std::uint32_t>(place);
  }
  fill_pool(guide, stream, ground, is_retained);
  return ground;
}

PouringPrefix StagedSpelling::no_stages(const Guide& /*guide*/, const Ground& ground) const {
  return {.pouring = no_balls(*this, ground.offsets_m),
          .is_used = std::vector<std::uint8_t>(ground.pool.size(), 0),
          .used_of_bin = std::vector<std::uint32_t>(balls(), 0)};
}

StagedSpelling::Choices StagedSpelling::choices(const Guide& guide, const Ground& ground,
                                                const Prefix& prefix) const {
  const std::uint32_t n = drops_per_bin(guide);
  const std::vector<std::uint8_t> full = full_bins(balls(), prefix.pouring.outcome.filling);
  const auto guess = [&](const PoolDrop& drop) {
    const double odds = odds_of(guide.odds, drop, full);
    const bool fills = drop.alone != k_fills_none && !is_full(full, drop.alone);
    return odds /
           (fills ? ground.bin_share[static_cast<std::size_t>(drop.alone)] : ground.mean_share);
  };
  Choices choices;
  for (std::size_t place = 0; place < ground.pool.size(); ++place) {
    const PoolDrop& drop = ground.pool[place];
    const bool can_be_chosen = prefix.is_used[place] == 0 && drop.v > 0;
    const double s = n / static_cast<double>(n - prefix.used_of_bin[place / n]);
    choices.guesses.push_back(can_be_chosen ? guess(drop) : 0);
    choices.shares.push_back(drop.v * choices.guesses.back() * s);
    choices.sum += choices.shares.back();
  }
  return choices;
}

sampling::Extension StagedSpelling::leave_out(const Guide& guide) const {
  return {.log_weight = math::log(0.5 / (1 - guide.takes_part))};
}

sampling::Extension StagedSpelling::drop(const Guide& guide, const Ground& ground,
                                         std::uint32_t stage, std::uint32_t place, Prefix& prefix,
                                         const Choices& choices) const {
  Pouring longer = with_ball(*this, prefix.pouring, stage, ground.pool[place].drop_m);
  sampling::Extension extension{.log_weight = sampling::k_log_zero,
                                .simulation = sampling::report_of<Spelling>(*this, longer.outcome)};
  if (!longer.outcome.is_animation()) return extension;
  extension.log_weight = math::log(0.5 / guide.takes_part) +
                         math::log(choices.sum / static_cast<double>(ground.pool.size())) -
                         math::log(choices.guesses[place]);
  prefix.pouring = std::move(longer);
  prefix.is_used[place] = 1;
  ++prefix.used_of_bin[place / drops_per_bin(guide)];
  return extension;
}

sampling::Extension StagedSpelling::extend(const Guide& guide, const Ground& ground,
                                           std::uint32_t stage, Prefix& prefix,
                                           random::Stream& stream) const {
  if (stream.uniform() >= guide.takes_part) return leave_out(guide);
  const Choices of_prefix = choices(guide, ground, prefix);
  if (!(of_prefix.sum > 0)) return {.log_weight = sampling::k_log_zero};
  const auto place = static_cast<std::uint32_t>(random::draw_by_share(of_prefix.shares, stream));
  return drop(guide, ground, stage, place, prefix, of_prefix);
}

sampling::Extension StagedSpelling::extend_as(const Guide& guide, const Ground& ground,
                                              const State& state, std::uint32_t stage,
                                              Prefix& prefix) const {
  if (state.active[stage] == 0) return leave_out(guide);
  return drop(guide, ground, stage, ground.retained[stage], prefix, choices(guide, ground, prefix));
}

double StagedSpelling::log_potential(const Guide& guide, const Ground& ground,
                                     const Prefix& prefix) const {
  const Outcome& outcome = prefix.pouring.outcome;
  // 0 * -infinity is NaN.
  double log_potential = outcome.elsewhere == 0 ? 0 : outcome.elsewhere * guide.log_elsewhere;
  for (const std::int16_t bin : outcome.filling) {
    if (bin == k_fills_none) continue;
    const double share = ground.bin_share[static_cast<std::size_t>(bin)];
    log_potential += parameters().constraint.log_lambda - math::log(share);
  }
  return log_potential;
}

}  // namespace sleight::worlds::spelling
