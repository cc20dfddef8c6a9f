#include "worker/worlds/spelling/pouring_stages.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "common/base/check.h"
#include "common/math/elementary.h"
#include "common/random/discrete_distributions.h"
#include "worker/sampling/log_sum.h"

namespace sleight::worlds::spelling {
namespace {

/// A bin's share is averaged with the mean share, which counts like this number of drops. So even
/// if no drop of the pool fills a bin, the bin's share is above 0.
constexpr double k_drops_of_the_mean = 3;
/// Minimum mean share. This minimum matters if no drop of a pool fills a bin.
constexpr double k_mean_share_min = 1e-5;

constexpr std::size_t k_ranges = std::tuple_size_v<DropOdds::ByDistance>;

/// Returns the index of a distance, in bins, in DropOdds::ByDistance.
std::uint8_t range_of(double bins) {
  return bins < 1 ? 0 : bins < 1.5 ? 1 : bins < 2.5 ? 2 : 3;
}

/// Kinds of drops. A sort is the number of a value in DropOdds. `own_bin` is sort 0. Kind k at
/// range r is sort 1 + (k - 1) k_ranges + r.
enum SortOfDrop : std::uint8_t { own_bin, beside, above_full, meets_full, misses };
constexpr std::size_t k_sorts = 1 + 4 * k_ranges;
constexpr std::size_t k_first_that_misses = 1 + 2 * k_ranges;  ///< fills no bin alone

std::array<double, k_sorts> by_sort(const DropOdds& odds) {
  std::array<double, k_sorts> all{odds.own_bin};
  std::size_t next = 1;
  for (const auto* kind : {&odds.beside, &odds.above_full, &odds.meets_full, &odds.misses})
    for (const double of_range : *kind)
      all[next++] = of_range;
  return all;
}

std::uint8_t sort_of(const PoolDrop& drop, const std::vector<std::uint8_t>& full) {
  const bool above = is_full(full, drop.below);
  const bool into = is_full(full, drop.alone);
  const bool fills = drop.alone != k_fills_none && !into;
  if (fills && drop.alone == drop.below) return own_bin;
  std::size_t range = k_ranges - 1;
  for (std::size_t i = 0; i < drop.near.size() && drop.near[i] != k_fills_none; ++i) {
    if (is_full(full, drop.near[i])) continue;
    range = drop.near_range[i];
    break;
  }
  const SortOfDrop kind = fills           ? (above ? above_full : beside)
                          : above || into ? meets_full
                                          : misses;
  return static_cast<std::uint8_t>(1 + (kind - 1) * k_ranges + range);
}

/// Returns the odds with which all particles together choose drops of each sort. The best number of
/// drops of a sort is proportional to the square root of its odds: n draws at odds p have a
/// variance proportional to p / n.
DropOdds flattened(const DropOdds& odds) {
  const auto root = [](double x) { return std::sqrt(x); };
  DropOdds flat{.own_bin = root(odds.own_bin)};
  std::ranges::transform(odds.beside, flat.beside.begin(), root);
  std::ranges::transform(odds.above_full, flat.above_full.begin(), root);
  std::ranges::transform(odds.meets_full, flat.meets_full.begin(), root);
  std::ranges::transform(odds.misses, flat.misses.begin(), root);
  return flat;
}

}  // namespace

std::string StagedSpelling::past_effort() const {
  return fmt::format(
      "drawing solutions in the model's proportions takes long; this request has {} balls. On two "
      "cores, "
      "five solutions took 15 to 40 s for HI (16 balls), 60 to 150 s for ACM (30 balls) and 250 to "
      "over 300 s for SLEIGHT (61 balls)",
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

PouringGuide StagedSpelling::for_odds(Guide guide) const {
  // A ball that fills no bin is worth slightly less than a ball that fills a bin.
  constexpr double k_log_less = 1;
  guide.odds = flattened(guide.odds);
  guide.log_elsewhere = parameters().constraint.log_lambda - k_log_less;
  guide.elsewhere_declines = true;
  guide.drops_per_bin = std::clamp(4 * balls(), guide.drops_per_bin, k_drops_per_bin_max);
  return guide;
}

std::vector<sampling::BurnInValue> StagedSpelling::burn_in_values() const {
  // A single ball has no other ball to help it.
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
    drop.near_range[i] = range_of(static_cast<float>(all[i].first));
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

  // For each bin, estimate the share of prior drops that fill the bin without other balls.
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

  // Put each ball's drop in an unused place. The place's stratum may have produced the drop.
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

template <class Visit>
void StagedSpelling::for_each_choice(const Guide& guide, const Ground& ground, const Prefix& prefix,
                                     const Visit& visit) const {
  const std::uint32_t n = drops_per_bin(guide);
  const std::vector<std::uint8_t> full = full_bins(balls(), prefix.pouring.outcome.filling);
  const std::array<double, k_sorts> of_sort = by_sort(guide.odds);
  for (std::size_t bin = 0, place = 0; bin < balls(); ++bin) {
    const double s = n / static_cast<double>(n - prefix.used_of_bin[bin]);
    for (std::uint32_t nth = 0; nth < n; ++nth, ++place) {
      const PoolDrop& drop = ground.pool[place];
      if (prefix.is_used[place] != 0 || !(drop.v > 0)) continue;
      const std::uint8_t sort = sort_of(drop, full);
      const double guess =
          of_sort[sort] / (sort < k_first_that_misses
                               ? ground.bin_share[static_cast<std::size_t>(drop.alone)]
                               : ground.mean_share);
      visit(place, sort, guess, drop.v * guess * s);
    }
  }
}

StagedSpelling::Choices StagedSpelling::choices(const Guide& guide, const Ground& ground,
                                                const Prefix& prefix) const {
  Choices choices{.guesses = std::vector<double>(ground.pool.size()),
                  .shares = std::vector<double>(ground.pool.size())};
  for_each_choice(guide, ground, prefix,
                  [&](std::size_t place, std::uint8_t, double guess, double share) {
                    choices.guesses[place] = guess;
                    choices.shares[place] = share;
                    choices.sum += share;
                  });
  return choices;
}

sampling::Extension StagedSpelling::leave_out(const Guide& guide) const {
  return {.log_weight = math::log(0.5 / (1 - guide.takes_part))};
}

sampling::Extension StagedSpelling::drop(const Guide& guide, const Ground& ground,
                                         std::uint32_t stage, std::size_t place, Prefix& prefix,
                                         double log_weight) const {
  Pouring longer = with_ball(*this, prefix.pouring, stage, ground.pool[place].drop_m);
  sampling::Extension extension{.log_weight = sampling::k_log_zero,
                                .simulation = sampling::report_of<Spelling>(*this, longer.outcome)};
  if (!longer.outcome.is_animation()) return extension;
  extension.log_weight = log_weight;
  prefix.pouring = std::move(longer);
  prefix.is_used[place] = 1;
  ++prefix.used_of_bin[place / drops_per_bin(guide)];
  return extension;
}

double StagedSpelling::log_weight_of(const Guide& guide, const Ground& ground,
                                     const Choices& choices, std::size_t place) const {
  return math::log(0.5 / guide.takes_part) +
         math::log(choices.sum / static_cast<double>(ground.pool.size())) -
         math::log(choices.guesses[place]);
}

sampling::Extension StagedSpelling::extend(const Guide& guide, const Ground& ground,
                                           std::uint32_t stage, Prefix& prefix,
                                           random::Stream& stream) const {
  if (stream.uniform() >= guide.takes_part) return leave_out(guide);
  const Choices all = choices(guide, ground, prefix);
  if (!(all.sum > 0)) return {.log_weight = sampling::k_log_zero};
  const std::size_t place = random::draw_by_share(all.shares, stream);
  return drop(guide, ground, stage, place, prefix, log_weight_of(guide, ground, all, place));
}

sampling::Extension StagedSpelling::extend_as(const Guide& guide, const Ground& ground,
                                              const State& state, std::uint32_t stage,
                                              Prefix& prefix) const {
  if (state.active[stage] == 0) return leave_out(guide);
  const std::uint32_t place = ground.retained[stage];
  const double log_weight = log_weight_of(guide, ground, choices(guide, ground, prefix), place);
  return drop(guide, ground, stage, place, prefix, log_weight);
}

std::size_t StagedSpelling::sorts() const {
  return k_sorts + 1;
}

/// The mass for leaving a ball out. This mass is always positive, but of little use if nothing can
/// be dropped.
double StagedSpelling::mass_left_out(const Guide& guide, double mass_of_drops) const {
  constexpr double k_mass_min = 1e-300;
  return std::max(mass_of_drops, k_mass_min) * (1 - guide.takes_part);
}

std::vector<double> StagedSpelling::masses(const Guide& guide, const Ground& ground,
                                           std::uint32_t /*stage*/, const Prefix& prefix) const {
  std::vector<double> masses(sorts(), 0);
  for_each_choice(guide, ground, prefix, [&](std::size_t, std::uint8_t sort, double, double share) {
    masses[sort] += share;
  });
  double sum = 0;
  for (double& mass : masses)
    sum += mass *= 0.5 / static_cast<double>(ground.pool.size());
  masses[k_sorts] = mass_left_out(guide, sum);
  return masses;
}

std::vector<sampling::Alternative> StagedSpelling::alternatives(const Guide& guide,
                                                                const Ground& ground,
                                                                std::uint32_t stage,
                                                                const Prefix& prefix,
                                                                std::size_t sort) const {
  if (sort == k_sorts) {
    const double mass = masses(guide, ground, stage, prefix)[k_sorts];
    return {{.number = ground.pool.size(), .mass = mass, .weight = 0.5 / mass}};
  }
  std::vector<sampling::Alternative> all;
  for_each_choice(guide, ground, prefix,
                  [&](std::size_t place, std::uint8_t of_drop, double guess, double share) {
                    if (of_drop != sort) return;
                    all.push_back({.number = place,
                                   .mass = 0.5 * share / static_cast<double>(ground.pool.size()),
                                   .weight = 1 / guess});
                  });
  return all;
}

sampling::Extension StagedSpelling::take(const Guide& guide, const Ground& ground,
                                         std::uint32_t stage, std::size_t number,
                                         Prefix& prefix) const {
  if (number == ground.pool.size()) return {};
  return drop(guide, ground, stage, number, prefix, 0);
}

double StagedSpelling::log_potential(const Guide& guide, const Ground& ground,
                                     const Prefix& prefix) const {
  const Outcome& outcome = prefix.pouring.outcome;
  // 0 * -infinity is NaN.
  double log_potential = outcome.elsewhere == 0 ? 0 : outcome.elsewhere * guide.log_elsewhere;
  if (outcome.elsewhere > 0 && guide.elsewhere_declines) {
    const std::uint32_t decided = std::min(outcome.filled + outcome.elsewhere, balls() - 1);
    log_potential += outcome.elsewhere * math::log(double(balls() - decided) / balls());
  }
  for (const std::int16_t bin : outcome.filling) {
    if (bin == k_fills_none) continue;
    const double share = ground.bin_share[static_cast<std::size_t>(bin)];
    log_potential += parameters().constraint.log_lambda - math::log(share);
  }
  return log_potential;
}

}  // namespace sleight::worlds::spelling
