#include "tests/statistical/mutants/islands/staged_reference.h"

#include <algorithm>
#include <cmath>

#include "common/math/elementary.h"
#include "common/random/discrete_distributions.h"
#include "worker/sampling/log_sum.h"

namespace sleight::statistical {
namespace {

using sampling::k_log_zero;

/// Returns the normalised weights.
std::vector<double> shares_of(const std::vector<double>& log_weights) {
  const double greatest = *std::ranges::max_element(log_weights);
  std::vector<double> shares;
  double sum = 0;
  for (const double log_weight : log_weights) {
    const double weight = log_weight == k_log_zero ? 0 : math::exp(log_weight - greatest);
    shares.push_back(weight);
    sum += weight;
  }
  for (double& share : shares)
    share /= sum;
  return shares;
}

double effective_size_of(const std::vector<double>& shares) {
  double squares = 0;
  for (const double share : shares)
    squares += share * share;
  return 1 / squares;
}

/// Arcs follow one another on a line, one per particle. An arc's length is N times the particle's
/// share of the weight. There are N points: offset, offset + 1, ... For each point, returns the
/// first particle whose arc ends beyond the point.
std::vector<std::uint32_t> particles_at_points(const std::vector<double>& shares, double offset) {
  const std::size_t count = shares.size();
  std::vector<double> ends;
  double end = 0;
  std::size_t last = 0;
  for (std::size_t n = 0; n < count; ++n) {
    ends.push_back(end += static_cast<double>(count) * shares[n]);
    if (shares[n] > 0) last = n;
  }
  std::vector<std::uint32_t> found;
  for (std::size_t point = 0; point < count; ++point) {
    std::size_t n = 0;
    while (n < last && offset + static_cast<double>(point) >= ends[n])
      ++n;
    found.push_back(static_cast<std::uint32_t>(n));
  }
  return found;
}

/// Rotates the ancestors: place n gets the ancestor of place n + `places`.
std::vector<std::uint32_t> turned(const std::vector<std::uint32_t>& ancestors,
                                  std::uint64_t places) {
  std::vector<std::uint32_t> result;
  for (std::size_t n = 0; n < ancestors.size(); ++n)
    result.push_back(ancestors[(n + places) % ancestors.size()]);
  return result;
}

std::vector<std::uint32_t> ancestors_by(const std::vector<double>& shares, random::Stream& stream) {
  const auto found = particles_at_points(shares, stream.uniform());
  return turned(found, random::UniformInteger{.count = found.size()}.draw(stream));
}

/// Draws ancestors, given that the first new particle descends from the first old particle. An
/// offset that puts n points into the first arc has weight n.
std::vector<std::uint32_t> ancestors_with_first(const std::vector<double>& shares,
                                                random::Stream& stream) {
  const double length = static_cast<double>(shares.size()) * shares[0];
  const double whole = std::floor(length);
  const double fraction = length - whole;
  const bool has_one_more = stream.uniform() < fraction * (whole + 1) / length;
  const double u = stream.uniform();
  const auto found =
      particles_at_points(shares, has_one_more ? fraction * u : fraction + (1 - fraction) * u);
  const auto of_first = static_cast<std::uint64_t>(std::ranges::count(found, 0U));
  return turned(found, random::UniformInteger{.count = of_first}.draw(stream));
}

double log_density(StagedToy::State state, double inverse_temperature) {
  return sampling::tempered_log_density(
      k_toy.log_prior(state), k_toy.log_constraint(k_toy.simulate(state)), inverse_temperature);
}

}  // namespace

ReferenceIslands::ReferenceIslands(const IslandSetting& setting,
                                   const sampling::ChainStreams& streams, Mistake mistake)
    : setting_(setting), streams_(streams), mistake_(mistake) {
  if (makes(Mistake::rescued_left_out)) setting_.guide.log_fallen = k_log_zero;
}

random::Stream ReferenceIslands::stream_of(random::Purpose purpose, std::uint64_t number,
                                           std::uint32_t stage, std::uint32_t particle) const {
  return random::Stream({.seed = streams_.seed,
                         .chain = streams_.chain,
                         .replica = base::ReplicaId{particle},
                         .purpose = purpose},
                        number * sampling::k_stages_max + stage);
}

random::Stream ReferenceIslands::acceptance_of(std::uint64_t number) const {
  return stream_of(random::Purpose::particle, number, 1, 0);
}

ReferenceIsland ReferenceIslands::free(std::uint64_t number) const {
  ReferenceIsland island = made(number, {});
  constexpr std::uint64_t k_more_islands = 1'000'000;
  for (std::uint64_t next = 1; makes(Mistake::dead_islands_made_again) && !island.drawn; ++next)
    island = made(number + next * k_more_islands, {});
  return island;
}

ReferenceIsland ReferenceIslands::given(std::uint64_t number, Toy::State state) const {
  return made(number, state);
}

ReferenceIsland ReferenceIslands::made(std::uint64_t number,
                                       std::optional<Toy::State> retained) const {
  Making making = begun(number, retained);
  for (std::uint32_t stage = 0; stage < Toy::k_stages; ++stage) {
    if (stage > 0) resample(making, stage - 1);
    for (std::uint32_t n = 0; n < setting_.options.particles; ++n)
      if (!making.particles[n].is_dead()) extend(making, stage, n);
    if (retained && making.particles[0].is_dead()) return {.is_unreachable = true};
    if (std::ranges::all_of(making.particles, &Particle::is_dead)) return {};
  }
  return finished(making);
}

ReferenceIslands::Making ReferenceIslands::begun(std::uint64_t number,
                                                 std::optional<Toy::State> retained) const {
  random::Stream stream = stream_of(random::Purpose::ground, number, 0, 0);
  Making making{.number = number, .retained = retained};
  making.ground = retained && !makes(Mistake::ground_drawn_anew)
                      ? k_toy.ground_given(setting_.guide, *retained, stream)
                      : k_toy.draw_ground(setting_.guide, stream);
  making.particles.resize(setting_.options.particles);
  for (Particle& particle : making.particles)
    particle.prefix = k_toy.no_stages(setting_.guide, making.ground);
  return making;
}

void ReferenceIslands::extend(Making& making, std::uint32_t stage, std::uint32_t n) const {
  Particle& particle = making.particles[n];
  const bool is_retained = making.retained && n == 0;

  // Choose, and move the walker.
  random::Stream stream = stream_of(random::Purpose::extension, making.number,
                                    makes(Mistake::stages_share_numbers) ? 0 : stage, n);
  const sampling::Extension extension =
      is_retained && !makes(Mistake::retained_drawn_anew)
          ? k_toy.extend_as(setting_.guide, making.ground, *making.retained, stage, particle.prefix)
          : k_toy.extend(setting_.guide, making.ground, stage, particle.prefix, stream);

  // Multiply the weight by the choice's weight and by the ratio of the new potential to the old
  // potential.
  const bool is_last = stage + 1 == Toy::k_stages;
  const double beta =
      makes(Mistake::temperature_forgotten) ? 1 : setting_.options.inverse_temperature;
  const double log_potential =
      is_last ? sampling::tempered_log_density(
                    0, k_toy.log_constraint(k_toy.outcome_of(particle.prefix)), beta)
              : k_toy.log_potential(setting_.guide, making.ground, particle.prefix);
  if (log_potential == k_log_zero) {
    particle.log_weight = k_log_zero;
    return;
  }
  const bool stays = makes(Mistake::potential_never_taken_off) ||
                     (makes(Mistake::potential_stays_at_the_end) && is_last);
  const double log_choice = makes(Mistake::choice_weight_left_out) ? 0.0 : extension.log_weight;
  if (!(is_retained && makes(Mistake::retained_weighs_one)))
    particle.log_weight += log_choice + (log_potential - (stays ? 0 : particle.log_potential));
  particle.log_potential = log_potential;
}

std::vector<std::uint32_t> ReferenceIslands::ancestors(const Making& making,
                                                       random::Stream& stream) const {
  const double power = makes(Mistake::resampled_by_squares) ? 2 : 1;
  std::vector<double> log_weights;
  for (const Particle& particle : making.particles)
    log_weights.push_back(power * particle.log_weight);
  const std::vector<double> shares = shares_of(log_weights);
  if (!making.retained || makes(Mistake::retained_resampled_away))
    return ancestors_by(shares, stream);
  if (!makes(Mistake::retained_put_over_another)) return ancestors_with_first(shares, stream);
  std::vector<std::uint32_t> ancestors = ancestors_by(shares, stream);
  ancestors[0] = 0;
  return ancestors;
}

void ReferenceIslands::resample(Making& making, std::uint32_t stage) const {
  std::vector<double> log_weights;
  for (const Particle& particle : making.particles)
    log_weights.push_back(particle.log_weight);
  const auto count = static_cast<double>(making.particles.size());
  if (effective_size_of(shares_of(log_weights)) >= setting_.options.resample_below * count) return;

  // Multiply Z by the mean weight; the new particles have weight 1.
  random::Stream stream = stream_of(random::Purpose::resampling, making.number, stage, 0);
  std::vector<Particle> next;
  for (const std::uint32_t ancestor : ancestors(making, stream)) {
    Particle& particle = next.emplace_back(making.particles[ancestor]);
    if (!makes(Mistake::resampled_keep_weights)) particle.log_weight = 0;
    if (makes(Mistake::potential_of_another_prefix))
      particle.log_potential = making.particles[next.size() - 1].log_potential;
  }
  if (!makes(Mistake::mean_weight_left_out)) making.log_z_before += log_mean_weight(making);
  making.particles = std::move(next);
}

double ReferenceIslands::log_mean_weight(const Making& making) const {
  sampling::LogSum sum;
  for (const Particle& particle : making.particles)
    if (!particle.is_dead() || !makes(Mistake::dead_left_out_of_the_mean))
      sum.add(particle.log_weight);
  return sum.log_mean();
}

double ReferenceIslands::log_satisfied(const Making& making) const {
  sampling::LogSum sum;
  for (const Particle& particle : making.particles) {
    const bool satisfies =
        !particle.is_dead() && k_toy.satisfied(k_toy.outcome_of(particle.prefix));
    // Remove the last potential, p_c, because P(satisfied) doesn't include it.
    double log_weight = particle.log_weight - particle.log_potential;
    if (makes(Mistake::constraint_left_in_satisfied)) log_weight = particle.log_weight;
    if (makes(Mistake::satisfied_are_counted)) log_weight = 0;
    sum.add(satisfies ? log_weight : k_log_zero);
  }
  if (makes(Mistake::satisfied_without_earlier_weights)) return sum.log_mean();
  return making.log_z_before + sum.log_mean();
}

std::uint32_t ReferenceIslands::drawn_particle(const Making& making) const {
  std::vector<double> log_weights;
  for (const Particle& particle : making.particles) {
    const bool is_equal = makes(Mistake::drawn_without_weights) && !particle.is_dead();
    log_weights.push_back(is_equal ? 0 : particle.log_weight);
  }
  if (making.retained && makes(Mistake::retained_never_drawn)) {
    log_weights[0] = k_log_zero;
    // Only the retained particle is alive.
    if (std::ranges::max(log_weights) == k_log_zero) return 0;
  }
  random::Stream stream = stream_of(random::Purpose::particle, making.number, 0, 0);
  return static_cast<std::uint32_t>(random::draw_by_share(shares_of(log_weights), stream));
}

ReferenceIsland ReferenceIslands::finished(const Making& making) const {
  std::vector<double> log_weights;
  ReferenceIsland island;
  for (const Particle& particle : making.particles) {
    log_weights.push_back(particle.log_weight);
    if (!particle.is_dead() && k_toy.satisfied(k_toy.outcome_of(particle.prefix)))
      ++island.satisfied;
  }
  island.log_z = making.log_z_before + log_mean_weight(making);
  island.log_satisfied = log_satisfied(making);
  island.effective_size = effective_size_of(shares_of(log_weights));
  island.drawn = k_toy.state_of(making.ground, making.particles[drawn_particle(making)].prefix);
  return island;
}

/// Returns islands whose guide is fixed before sampling.
ReferenceIslands ReferenceSteps::islands(const ReferenceChain& chain) const {
  IslandSetting setting = setting_;
  if (makes(Mistake::guide_learns_from_the_chain) && !StagedToy::has_fallen(chain.state))
    setting.guide.log_fallen = k_log_zero;
  return {setting, streams_, mistake_};
}

void ReferenceSteps::conditional(std::uint64_t number, ReferenceChain& chain) const {
  if (makes(Mistake::fresh_island_spared) && chain.log_z) return;
  const ReferenceIsland island = islands(chain).given(number, chain.state);
  if (island.is_unreachable) return;
  chain = {.state = *island.drawn, .log_z = island.log_z};
}

void ReferenceSteps::independent(std::uint64_t number, ReferenceChain& chain) const {
  const ReferenceIslands islands_now = islands(chain);

  // If Z is stale, estimate it from an island given the current state.
  bool stays = false;
  if (!chain.log_z) {
    const ReferenceIsland own = makes(Mistake::stale_z_of_a_free_island)
                                    ? islands_now.free(number)
                                    : islands_now.given(number, chain.state);
    stays = own.is_unreachable && !makes(Mistake::unreachable_state_leaves);
    if (!stays) chain.log_z = own.log_z;
  }

  // Propose a free island, and accept it with probability min(1, Z' / Z).
  const ReferenceIsland island = islands_now.free(number + 1);
  if (stays || !island.drawn) return;
  random::Stream acceptance = islands_now.acceptance_of(number + 1);
  double log_ratio = island.log_z - *chain.log_z;
  if (makes(Mistake::every_island_accepted)) log_ratio = 1;
  if (makes(Mistake::accepted_by_the_draw)) {
    log_ratio = k_toy.log_constraint(k_toy.simulate(*island.drawn)) -
                k_toy.log_constraint(k_toy.simulate(chain.state));
  }
  const bool accepts = math::log(acceptance.uniform()) < log_ratio;
  if (accepts) chain.state = *island.drawn;
  if (accepts || makes(Mistake::rejected_island_gives_z)) chain.log_z = island.log_z;
}

void ReferenceSteps::local(std::uint64_t iteration, ReferenceChain& chain) const {
  random::Stream proposing = streams_.at(random::Purpose::proposal, iteration);
  random::Stream accepting = streams_.at(random::Purpose::acceptance, iteration);
  const StagedToy::State candidate = k_toy.propose(chain.state, proposing).candidate;
  const double beta = setting_.options.inverse_temperature;
  const double log_ratio = log_density(candidate, beta) - log_density(chain.state, beta);
  if (math::log(accepting.uniform()) >= log_ratio) return;
  chain.state = candidate;
  if (!makes(Mistake::stale_z_kept)) chain.log_z.reset();
}

void ReferenceSteps::visit(std::uint64_t scan, ReferenceChain& chain) const {
  constexpr std::uint64_t k_free_islands = 3;
  const std::uint64_t number = scan * (1 + 2 * k_free_islands);
  chain.log_z.reset();
  if (k_toy.log_constraint(k_toy.simulate(chain.state)) == k_log_zero) {
    chain.log_z = k_log_zero;
  } else {
    conditional(number, chain);
  }
  for (std::uint64_t nth = 0; nth < k_free_islands; ++nth)
    independent(number + 1 + 2 * nth, chain);
}

}  // namespace sleight::statistical
