// Worlds for tests of tempering. Tempered distributions of these worlds are known exactly.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "common/base/bytes.h"
#include "common/random/linear_distributions.h"
#include "worker/run/chain_worker.h"
#include "worker/sampling/target.h"

namespace sleight::statistical {

/// Fourteen places in a ring, with hills and valleys of p_c. Three places with p_c = 0 cut the ring
/// into parts. If the inverse temperature is above 0, no step connects the parts. A step moves one
/// place, more often clockwise.
struct RuggedRing {
  using State = std::uint32_t;
  using Outcome = std::uint32_t;
  static constexpr std::size_t k_places = 14;
  static constexpr double k_infinity = std::numeric_limits<double>::infinity();
  static constexpr std::array<double, k_places> k_prior{0.05, 0.1,  0.02, 0.08, 0.12, 0.05, 0.08,
                                                        0.1,  0.05, 0.07, 0.03, 0.1,  0.1,  0.05};
  static constexpr std::array<double, k_places> k_log_constraint{
      -1, -4, 0.5, -k_infinity, -2, 1, -3, -0.5, -k_infinity, -1.5, 2, -5, -k_infinity, -2.5};
  static constexpr double k_clockwise = 0.65;

  static std::vector<double> exact(double beta) {
    std::vector<double> p;
    double sum = 0;
    for (std::size_t i = 0; i < k_places; ++i) {
      const double constraint = beta == 0 ? 1 : std::exp(beta * k_log_constraint[i]);
      sum += p.emplace_back(k_prior[i] * constraint);
    }
    for (double& x : p)
      x /= sum;
    return p;
  }
  template <class Probabilities>
  static State pick(const Probabilities& p, double u) {
    State state = 0;
    while (state + 1 < k_places && u >= p[state])
      u -= p[state++];
    return state;
  }

  State draw_exact(double beta, random::Stream& stream) const {
    return pick(exact(beta), stream.uniform());
  }
  State draw_prior(random::Stream& stream) const { return pick(k_prior, stream.uniform()); }
  double log_prior(const State& state) const { return std::log(k_prior[state]); }
  Outcome simulate(const State& state) const { return state; }
  double log_constraint(const Outcome& outcome) const { return k_log_constraint[outcome]; }
  bool satisfied(const Outcome& outcome) const { return outcome == 5 || outcome == 10; }
  std::uint32_t proposal_kinds() const { return 1; }
  sampling::Proposal<State> propose(const State& state, random::Stream& stream) const {
    const bool clockwise = stream.uniform() < k_clockwise;
    const double odds = std::log((1 - k_clockwise) / k_clockwise);
    return {.candidate = static_cast<State>((state + (clockwise ? 1 : k_places - 1)) % k_places),
            .log_q_ratio = clockwise ? odds : -odds,
            .kind = 0};
  }
  std::size_t owned_bytes(const State&, const Outcome&) const { return 0; }
  base::Bytes encode(const State& state) const {
    base::ByteWriter writer;
    writer.put(state);
    return writer.take();
  }
  std::optional<State> decode(base::BytesView bytes) const {
    return base::ByteReader(bytes).get<State>();
  }
  std::vector<double> outcome_values(const Outcome& outcome) const {
    return {static_cast<double>(outcome)};
  }
};
static_assert(run::World<RuggedRing>);

/// Base class of worlds on the line. The prior is N(0, prior_sd), and steps are N(0, step_sd).
struct Line {
  using State = double;
  using Outcome = double;
  double prior_sd = 1;
  double step_sd = 1;

  State draw_prior(random::Stream& stream) const {
    return random::Normal{.mean = 0, .sd = prior_sd}.draw(stream);
  }
  double log_prior(const State& x) const {
    return random::Normal{.mean = 0, .sd = prior_sd}.log_density(x);
  }
  Outcome simulate(const State& x) const { return x; }
  std::uint32_t proposal_kinds() const { return 1; }
  sampling::Proposal<State> propose(const State& x, std::span<const double> scales,
                                    random::Stream& stream) const {
    const double sd = step_sd * (scales.empty() ? 1 : scales.front());
    return {.candidate = x + random::Normal{.mean = 0, .sd = sd}.draw(stream),
            .log_q_ratio = 0,
            .kind = 0};
  }
  bool has_scale(std::uint32_t /*kind*/) const { return true; }
  std::size_t owned_bytes(const State&, const Outcome&) const { return 0; }
  base::Bytes encode(const State& x) const {
    base::ByteWriter writer;
    writer.put(x);
    return writer.take();
  }
  std::optional<State> decode(base::BytesView bytes) const {
    return base::ByteReader(bytes).get<double>();
  }
  std::vector<double> outcome_values(const Outcome& x) const { return {x}; }
};

/// p_c = exp(-((x - target) / sigma)^2 / 2): every tempered distribution is Gaussian.
struct Bullseye : Line {
  double target = 0;
  double sigma = 0.1;
  double tolerance = 0.1;

  double log_constraint(const Outcome& x) const {
    const double deviation = (x - target) / sigma;
    return -0.5 * deviation * deviation;
  }
  bool satisfied(const Outcome& x) const { return std::abs(x - target) <= tolerance; }

  State draw_exact(double beta, random::Stream& stream) const {
    const double precision = 1 / (prior_sd * prior_sd) + beta / (sigma * sigma);
    const double mean = beta * target / (sigma * sigma) / precision;
    return random::Normal{.mean = mean, .sd = 1 / std::sqrt(precision)}.draw(stream);
  }
  double log_z() const {
    const double variance = sigma * sigma + prior_sd * prior_sd;
    return 0.5 * std::log(sigma * sigma / variance) - 0.5 * target * target / variance;
  }
  double log_p_satisfied() const {
    const auto below = [&](double x) { return 0.5 * std::erfc(-x / prior_sd / std::sqrt(2.0)); };
    return std::log(below(target + tolerance) - below(target - tolerance));
  }
};
static_assert(run::World<Bullseye> && sampling::ScalesProposals<Bullseye>);

/// p_c is the sum of two narrow Gaussians, left and right of 0. The Gaussians are so far apart that
/// a random walk never crosses from one to the other.
struct TwoModes : Line {
  double place = 6;
  double sigma = 0.2;
  double left_height = 0.25;  ///< p_c at the left peak; the right peak has 1.

  double log_constraint(const Outcome& x) const {
    const double left = (x + place) / sigma;
    const double right = (x - place) / sigma;
    const double a = std::log(left_height) - 0.5 * left * left;
    const double b = -0.5 * right * right;
    return std::max(a, b) + std::log1p(std::exp(-std::abs(a - b)));
  }
  bool satisfied(const Outcome& x) const { return std::abs(std::abs(x) - place) < sigma; }
  /// Both modes have the same width, and the prior is symmetric. So the odds of the modes are the
  /// ratio of their heights.
  double left_weight() const { return left_height / (1 + left_height); }
  State draw_exact(random::Stream& stream) const {
    const double precision = 1 / (prior_sd * prior_sd) + 1 / (sigma * sigma);
    const double mean = place / (sigma * sigma) / precision;
    const bool left = stream.uniform() < left_weight();
    return random::Normal{.mean = left ? -mean : mean, .sd = 1 / std::sqrt(precision)}.draw(stream);
  }
};
static_assert(run::World<TwoModes>);

/// A worker that starts replicas at exact draws. Another worker runs all other units.
template <class World>
class ExactStarts final : public plan::UnitWorker {
 public:
  ExactStarts(World world, std::uint64_t seed, const plan::UnitWorker& rest)
      : world_(std::move(world)), seed_(seed), rest_(rest) {}

  plan::UnitResult run(const plan::Unit& unit, base::BytesView state) const override {
    if (!unit.starts) return rest_.run(unit, state);
    const double beta = unit.inverse_temperature(0);
    random::Stream stream({.seed = seed_,
                           .chain = unit.replica.chain,
                           .replica = unit.replica.replica,
                           .purpose = random::Purpose::start},
                          unit.first_scan.value);
    const auto x = world_.draw_exact(beta, stream);
    const auto outcome = world_.simulate(x);
    plan::ScanRecord record;
    record.log_prior = world_.log_prior(x);
    record.log_constraint = world_.log_constraint(outcome);
    record.satisfied = world_.satisfied(outcome);
    record.lineage = plan::lineage_from(unit.replica.replica, unit.first_scan.value);
    record.inverse_temperature = beta;
    record.outcome = world_.outcome_values(outcome);
    return {.unit = unit, .scans = {record}, .state_after = world_.encode(x)};
  }

 private:
  World world_;
  std::uint64_t seed_;
  const plan::UnitWorker& rest_;
};

/// A worker that explores perfectly: every scan is an independent exact draw.
template <class World>
class ExactScans final : public plan::UnitWorker {
 public:
  ExactScans(World world, std::uint64_t seed) : starts_(std::move(world), seed, *this) {}
  plan::UnitResult run(const plan::Unit& unit, base::BytesView /*state*/) const override {
    plan::Unit fresh = unit;
    fresh.starts = true;
    plan::UnitResult result = starts_.run(fresh, {});
    result.unit = unit;
    if (!unit.starts && unit.inverse_temperature(0) != 0)
      result.scans.front().lineage = unit.lineage;
    return result;
  }

 private:
  ExactStarts<World> starts_;
};

}  // namespace sleight::statistical
