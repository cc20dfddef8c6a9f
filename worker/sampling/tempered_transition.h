// Tempered transitions (Neal 1996, Sampling from multimodal distributions using tempered
// transitions): one Metropolis-Hastings step. The candidate moves down through hotter distributions
// and up again.
//
// Let beta_0 > beta_1 > ... > beta_K. Each beta has a kernel that leaves beta's distribution
// invariant. Kernels move x through beta_1 ... beta_K and back through beta_K ... beta_1. The final
// state is accepted with probability min(1, ratio), where
//
//   log ratio = sum over k of (beta_{k+1} - beta_k) (l(x_k) - l(x'_k)),    l = log p_c.
//
// x_k is the state that goes down from beta_k, and x'_k the state that comes up to beta_k. All
// kernels are reversible. At inverse temperature 0 the two passes merge into one prior draw.
#pragma once

#include <cstdint>
#include <span>
#include <utility>

#include "common/base/check.h"
#include "common/math/elementary.h"
#include "worker/sampling/metropolis_hastings.h"
#include "worker/sampling/surrogate_transition.h"
#include "worker/sampling/temperature_steps.h"

namespace sleight::sampling {

/// Maximum number of steps of one excursion. Each scan reserves this many iteration numbers, so no
/// two excursions share a number.
inline constexpr std::uint64_t k_excursion_steps_max = std::uint64_t{1} << 20U;

struct Excursion {
  double inverse_temperature = 1;           ///< Inverse temperature of the start and end.
  std::span<const double> below;            ///< beta_1 .. beta_K, descending; the last may be 0.
  std::uint32_t steps = 1;                  ///< Steps at each temperature and in each direction.
  std::span<const double> proposal_scales;  ///< Proposal scales by kind; empty for 1.
};

struct ExcursionReport {
  bool accepted = false;
  bool from_prior = false;  ///< The accepted state descends from a new prior draw.
  std::uint64_t simulations = 0;
};

/// Calls `told` for each simulation. REQUIRES: each scan of a replica at most once; fewer than
/// k_excursion_steps_max steps in total.
template <Target T, class Told = TellNobody>
ExcursionReport tempered_transition(const T& target, const Excursion& excursion,
                                    const ChainStreams& streams, std::uint64_t scan,
                                    Sample<T>& current, const Told& told = {}) {
  CHECK_LT(2 * excursion.below.size() * excursion.steps, k_excursion_steps_max);
  // Use iteration numbers that only this excursion has, above the numbers of plain iterations.
  std::uint64_t iteration = (std::uint64_t{1} << 63U) + scan * k_excursion_steps_max;
  Sample<T> candidate = current;
  double log_ratio = 0;
  bool from_prior = false;
  std::uint64_t simulations = 0;
  const auto move = [&](double beta) {
    if (beta == 0) {
      candidate = draw_afresh(target, streams, scan, [&](const SimulationReport& report) {
        ++simulations;
        told(report);
      });
      from_prior = true;
      return;
    }
    for (std::uint32_t i = 0; i < excursion.steps; ++i)
      iterate(target, beta, streams, iteration++, candidate, excursion.proposal_scales,
              [&](const StepReport& step) {
                simulations += step.simulated ? 1 : 0;
                told(step.simulation);
              });
  };
  // Weigh a step. If the start breaks a hard constraint, its density is 0, and the excursion
  // accepts any candidate of positive density.
  const auto weighs = [&](double above, double below, bool down) {
    log_ratio += excursion_log_weight(
        {.above = above, .below = below, .l = candidate.log_constraint, .down = down});
  };

  // Go down to the hottest distribution and up again.
  double above = excursion.inverse_temperature;
  for (const double beta : excursion.below) {
    weighs(above, beta, true);
    move(beta);
    above = beta;
  }
  for (std::size_t k = excursion.below.size(); k-- > 0;) {
    const double beta = excursion.below[k];
    if (beta != 0) move(beta);
    weighs(k == 0 ? excursion.inverse_temperature : excursion.below[k - 1], beta, false);
  }

  const double log_u = math::log(streams.at(random::Purpose::excursion, scan).uniform());
  if (!(log_u < log_ratio)) return {.simulations = simulations};
  current = std::move(candidate);
  return {.accepted = true, .from_prior = from_prior, .simulations = simulations};
}

}  // namespace sleight::sampling
