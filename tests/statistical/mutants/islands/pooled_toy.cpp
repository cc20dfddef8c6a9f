#include "tests/statistical/mutants/islands/pooled_toy.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/math/elementary.h"
#include "common/random/discrete_distributions.h"
#include "worker/sampling/log_sum.h"

namespace sleight::statistical {
namespace {

using Spots = std::array<double, PooledToy::k_spots>;

constexpr Spots k_prior{0.3, 0.15, 0.05, 0.3, 0.2};
/// For each bin, the distribution of drops that are aimed at the bin.
constexpr std::array<Spots, PooledToy::k_bins> k_aimed{Spots{0.5, 0.4, 0.1, 0, 0},
                                                       Spots{0, 0, 0.7, 0.2, 0.1}};
constexpr double k_prior_share = 0.05;

/// The bin into which a ball falls if all bins are empty. k_bins: elsewhere.
constexpr std::array<std::uint32_t, PooledToy::k_spots> k_alone{0, 0, 1, 2, 2};

/// q of a stratum.
double density_of(std::uint32_t bin, std::uint32_t spot) {
  return k_prior_share * k_prior.at(spot) + (1 - k_prior_share) * k_aimed.at(bin).at(spot);
}

std::uint32_t draw_of(std::uint32_t bin, random::Stream& stream) {
  Spots densities{};
  for (std::uint32_t spot = 0; spot < densities.size(); ++spot)
    densities[spot] = density_of(bin, spot);
  return static_cast<std::uint32_t>(random::draw_by_share(densities, stream));
}

/// Returns p / q of a spot, where q is the mean of the strata's densities.
double prior_over_q(std::uint32_t spot) {
  double sum = 0;
  for (std::uint32_t bin = 0; bin < PooledToy::k_bins; ++bin)
    sum += density_of(bin, spot);
  return k_prior.at(spot) * PooledToy::k_bins / sum;
}

/// Guesses how promising a drop is, given the outcome of the earlier balls. The method is exact for
/// any guess.
double guess_of(std::uint32_t spot, const PooledToy::Outcome& outcome) {
  const std::uint32_t bin = k_alone.at(spot);
  return bin < PooledToy::k_bins && !outcome.is_full.at(bin) ? 0.9 : 0.2;
}

/// Adds one ball. If its bin is full, the ball falls elsewhere, or rolls into bin 1 if it comes
/// from spot 1.
PooledToy::Outcome with_ball(PooledToy::Outcome outcome, std::uint32_t spot) {
  std::uint32_t bin = k_alone.at(spot);
  if (spot == 1 && outcome.is_full[0]) bin = 1;
  if (bin == PooledToy::k_bins || outcome.is_full.at(bin)) {
    ++outcome.elsewhere;
  } else {
    outcome.is_full.at(bin) = true;
  }
  return outcome;
}

}  // namespace

std::uint32_t PooledToy::choice_of(State state, std::uint32_t ball) {
  constexpr std::array<State, k_balls> k_weights{k_choices * k_choices, k_choices, 1};
  return state / k_weights.at(ball) % k_choices;
}

PooledToy::State PooledToy::draw_prior(random::Stream& stream) const {
  State state = 0;
  for (std::uint32_t ball = 0; ball < k_balls; ++ball) {
    const bool takes_part = stream.uniform() < 0.5;
    const auto spot = static_cast<std::uint32_t>(random::draw_by_share(k_prior, stream));
    state = state * k_choices + (takes_part ? 1 + spot : 0);
  }
  return state;
}

double PooledToy::log_prior(const State& state) const {
  double p = 1;
  for (std::uint32_t ball = 0; ball < k_balls; ++ball) {
    const std::uint32_t choice = choice_of(state, ball);
    p *= choice == 0 ? 0.5 : 0.5 * k_prior.at(choice - 1);
  }
  return math::log(p);
}

PooledToy::Outcome PooledToy::simulate(const State& state) const {
  Outcome outcome;
  for (std::uint32_t ball = 0; ball < k_balls; ++ball) {
    const std::uint32_t choice = choice_of(state, ball);
    if (choice > 0) outcome = with_ball(outcome, choice - 1);
  }
  return outcome;
}

double PooledToy::log_constraint(const Outcome& outcome) const {
  const double filled = (outcome.is_full[0] ? 1 : 0) + (outcome.is_full[1] ? 1 : 0);
  return 1.5 * filled - outcome.elsewhere;
}

sampling::Proposal<PooledToy::State> PooledToy::propose(const State& state,
                                                        random::Stream& stream) const {
  const std::uint64_t at = random::UniformInteger{.count = k_balls}.draw(stream);
  const std::uint64_t by = 1 + random::UniformInteger{.count = k_choices - 1}.draw(stream);
  State candidate = 0;
  for (std::uint32_t ball = 0; ball < k_balls; ++ball) {
    const std::uint32_t choice = choice_of(state, ball);
    candidate = candidate * k_choices +
                (ball == at ? static_cast<std::uint32_t>((choice + by) % k_choices) : choice);
  }
  return {.candidate = candidate};
}

std::uint32_t PooledToy::drops_of_stratum() const {
  return makes(PoolMistake::stratum_used_up) ? k_balls - 1 : k_balls;
}

PooledToy::Ground PooledToy::draw_ground(const Guide& /*guide*/, random::Stream& stream) const {
  Ground ground;
  for (std::uint32_t bin = 0; bin < k_bins; ++bin)
    for (std::uint32_t nth = 0; nth < drops_of_stratum(); ++nth)
      ground.spots.push_back(draw_of(bin, stream));
  return ground;
}

/// Draws a stratum for each ball's drop, in proportion to the strata's densities. Puts the drop
/// into an unused place of this stratum.
PooledToy::Ground PooledToy::ground_given(const Guide& guide, const State& state,
                                          random::Stream& stream) const {
  const std::uint32_t n = drops_of_stratum();
  Ground ground = draw_ground(guide, stream);
  std::vector<bool> is_retained(ground.spots.size(), false);
  for (std::uint32_t ball = 0; ball < k_balls; ++ball) {
    const std::uint32_t choice = choice_of(state, ball);
    if (choice == 0) continue;
    std::array<double, k_bins> densities{1, 0};
    for (std::uint32_t bin = 0; bin < k_bins; ++bin)
      if (!makes(PoolMistake::retained_stands_first))
        densities.at(bin) = density_of(bin, choice - 1);
    const auto bin = static_cast<std::uint32_t>(random::draw_by_share(densities, stream));
    std::vector<std::uint32_t> places;
    for (std::uint32_t place = bin * n; place < (bin + 1) * n; ++place)
      if (!is_retained[place] || makes(PoolMistake::retained_drops_share_a_place))
        places.push_back(place);
    const std::uint32_t place =
        places.at(random::UniformInteger{.count = places.size()}.draw(stream));
    is_retained[place] = true;
    if (!makes(PoolMistake::retained_not_in_the_pool)) ground.spots[place] = choice - 1;
    ground.retained.at(ball) = place;
  }
  return ground;
}

PooledToy::Prefix PooledToy::no_stages(const Guide& /*guide*/, const Ground& ground) const {
  return {.is_used = std::vector<bool>(ground.spots.size(), false)};
}

std::uint32_t PooledToy::unused_of_stratum(const Prefix& prefix, std::uint32_t bin) const {
  std::uint32_t unused = 0;
  for (std::uint32_t nth = 0; nth < drops_of_stratum(); ++nth)
    unused += prefix.is_used[bin * drops_of_stratum() + nth] ? 0 : 1;
  return unused;
}

PooledToy::Choices PooledToy::choices(const Ground& ground, const Prefix& prefix) const {
  const std::uint32_t n = drops_of_stratum();
  Choices choices;
  for (std::uint32_t place = 0; place < ground.spots.size(); ++place) {
    const std::uint32_t spot = ground.spots[place];
    // The factor n / unused corrects for drops of the stratum that are already used.
    double s = n / static_cast<double>(std::max(unused_of_stratum(prefix, place / n), 1U));
    if (makes(PoolMistake::walk_count_left_out)) s = 1;
    const double v = makes(PoolMistake::prior_weight_left_out) ? 1 : prior_over_q(spot);
    const double share = v * s * guess_of(spot, prefix.outcome);
    const bool is_used = prefix.is_used[place];
    choices.shares.push_back(is_used ? 0 : share);
    if (!is_used || makes(PoolMistake::used_drops_in_the_sum)) choices.sum += share;
  }
  return choices;
}

sampling::Extension PooledToy::leave_out(const Guide& guide, Prefix& prefix) const {
  prefix.digits *= k_choices;
  if (makes(PoolMistake::part_left_out)) return {};
  return {.log_weight = math::log(0.5 / (1 - guide.takes_part))};
}

sampling::Extension PooledToy::drop(const Guide& guide, const Ground& ground, std::uint32_t place,
                                    Prefix& prefix) const {
  // Compute the weight S / (K g) before the ball changes the choices.
  const std::uint32_t spot = ground.spots[place];
  const std::ptrdiff_t drops = makes(PoolMistake::unused_drops_counted)
                                   ? std::ranges::count(prefix.is_used, false)
                                   : std::ssize(ground.spots);
  double weight = choices(ground, prefix).sum / static_cast<double>(drops);
  if (makes(PoolMistake::pool_weight_left_out)) weight = 1;
  if (!makes(PoolMistake::guess_left_in)) weight /= guess_of(spot, prefix.outcome);
  if (!makes(PoolMistake::part_left_out)) weight *= 0.5 / guide.takes_part;

  prefix.digits = prefix.digits * k_choices + 1 + spot;
  prefix.outcome = with_ball(prefix.outcome, spot);
  if (!makes(PoolMistake::drop_used_twice)) prefix.is_used[place] = true;
  return {.log_weight = math::log(weight)};
}

sampling::Extension PooledToy::extend(const Guide& guide, const Ground& ground,
                                      std::uint32_t /*stage*/, Prefix& prefix,
                                      random::Stream& stream) const {
  if (stream.uniform() >= guide.takes_part) return leave_out(guide, prefix);
  const std::vector<double> shares = choices(ground, prefix).shares;
  if (std::ranges::max(shares) == 0) return {.log_weight = sampling::k_log_zero};
  return drop(guide, ground, static_cast<std::uint32_t>(random::draw_by_share(shares, stream)),
              prefix);
}

sampling::Extension PooledToy::extend_as(const Guide& guide, const Ground& ground,
                                         const State& state, std::uint32_t stage,
                                         Prefix& prefix) const {
  if (choice_of(state, stage) == 0) return leave_out(guide, prefix);
  return drop(guide, ground, ground.retained.at(stage), prefix);
}

double PooledToy::log_potential(const Guide& guide, const Ground& /*ground*/,
                                const Prefix& prefix) const {
  const double filled = (prefix.outcome.is_full[0] ? 1 : 0) + (prefix.outcome.is_full[1] ? 1 : 0);
  return 1.2 * filled + guide.log_elsewhere * prefix.outcome.elsewhere;
}

std::vector<double> PooledToy::masses(double beta) const {
  std::vector<double> masses;
  for (State state = 0; state < k_states; ++state)
    masses.push_back(std::exp(
        sampling::tempered_log_density(log_prior(state), log_constraint(simulate(state)), beta)));
  return masses;
}

}  // namespace sleight::statistical
