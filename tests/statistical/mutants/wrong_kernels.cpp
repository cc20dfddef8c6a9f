// Mistakes in densities, proposals and steps.
#include <cmath>
#include <limits>

#include "common/math/elementary.h"
#include "tests/statistical/mutants/mutant.h"

namespace sleight::statistical {
namespace {

using Proposal = sampling::Proposal<std::uint32_t>;
using Sample = sampling::Sample<Ring>;
using Streams = sampling::ChainStreams;

/// Makes a step in which the first number of the proposal's stream also decides about acceptance.
void reuse_the_number(const Ring& ring, double beta, const Streams& streams,
                      std::uint64_t iteration, Sample& current) {
  random::Stream stream = streams.at(random::Purpose::proposal, iteration);
  const Proposal proposal = ring.propose(current.state, stream);
  const Sample candidate = sampling::evaluate(ring, proposal.candidate);
  const double log_ratio =
      sampling::log_acceptance_ratio(current.log_prior, current.log_constraint, candidate.log_prior,
                                     candidate.log_constraint, beta, proposal.log_q_ratio);
  random::Stream again = streams.at(random::Purpose::proposal, iteration);
  if (math::log(again.uniform()) < log_ratio) current = candidate;
}

void keep_the_old_density(const Ring& ring, double beta, const Streams& streams,
                          std::uint64_t iteration, Sample& current) {
  const double old = current.log_constraint;
  sampling::metropolis_hastings_step(ring, beta, streams, iteration, current);
  current.log_constraint = old;
}

void keep_the_rejected_density(const Ring& ring, double beta, const Streams& streams,
                               std::uint64_t iteration, Sample& current) {
  random::Stream stream = streams.at(random::Purpose::proposal, iteration);
  const double proposed = ring.log_constraint(ring.propose(current.state, stream).candidate);
  sampling::metropolis_hastings_step(ring, beta, streams, iteration, current);
  if (!std::isinf(proposed)) current.log_constraint = proposed;
}

void go_on_until_accepted(const Ring& ring, double beta, const Streams& streams,
                          std::uint64_t iteration, Sample& current) {
  for (std::uint64_t attempt = 0; attempt < 100; ++attempt) {
    if (sampling::metropolis_hastings_step(ring, beta, streams, iteration * 100 + attempt, current)
            .accepted)
      return;
  }
}

void use_each_number_twice(const Ring& ring, double beta, const Streams& streams,
                           std::uint64_t iteration, Sample& current) {
  sampling::metropolis_hastings_step(ring, beta, streams, (iteration + 1) / 2, current);
}

void mistake_the_temperature(const Ring& ring, double beta, const Streams& streams,
                             std::uint64_t iteration, Sample& current) {
  sampling::metropolis_hastings_step(ring, beta * beta * 0.8, streams, iteration, current);
}

}  // namespace

std::vector<Mutant> wrong_kernels() {
  using enum CheckId;
  return {
      {.name = "ratio dropped",
       .what = "no proposal's ratio q(x|y) / q(y|x) is counted",
       .checks = {kernel_keeps},
       .lies = {.proposal = [](std::uint32_t, Proposal& p) { p.log_q_ratio = 0; }}},
      {.name = "ratio inverted",
       .what = "proposals' ratios are counted the other way round",
       .checks = {kernel_keeps},
       .lies = {.proposal = [](std::uint32_t, Proposal& p) { p.log_q_ratio *= -1; }}},
      {.name = "independence as symmetric",
       .what = "a draw that doesn't hang on the state is taken for a symmetric proposal",
       .checks = {kernel_keeps},
       .lies = {.proposal =
                    [](std::uint32_t, Proposal& p) {
                      if (p.kind == 1) p.log_q_ratio = 0;
                    }}},
      {.name = "one kind's ratio for all",
       .what = "every kind of proposal is given the ratio of the independent draw",
       .checks = {kernel_keeps},
       .lies = {.proposal =
                    [](std::uint32_t from, Proposal& p) {
                      p.log_q_ratio =
                          math::log(RuggedRing::k_prior[from] / RuggedRing::k_prior[p.candidate]);
                    }}},
      {.name = "size hangs on the state",
       .what = "steps from even places are twice as long, and nothing makes up for it",
       .checks = {kernel_keeps},
       .lies = {.proposal =
                    [](std::uint32_t from, Proposal& p) {
                      if (p.kind == 1 || from % 2 == 1) return;
                      const auto places = static_cast<std::uint32_t>(RuggedRing::k_places);
                      p.candidate = (2 * p.candidate + places - from) % places;
                    }}},
      {.name = "prior forgotten",
       .what = "the prior's density counts as 1 everywhere",
       .checks = {kernel_keeps},
       .lies = {.log_prior = [](double) { return 0.0; }}},
      {.name = "prior twice",
       .what = "the prior's density is squared",
       .checks = {kernel_keeps},
       .lies = {.log_prior = [](double log_prior) { return 2 * log_prior; }}},
      {.name = "zero density as one",
       .what = "log p_c of -inf is treated as 0",
       .checks = {kernel_keeps},
       .lies = {.log_constraint = zero_for_log_zero}},
      {.name = "constraint cut off",
       .what = "log p_c below -2 counts as -2",
       .checks = {kernel_keeps},
       .lies = {.log_constraint = [](double l) { return std::isinf(l) ? l : std::max(l, -2.0); }}},
      {.name = "prior drawn evenly",
       .what = "draws from the prior take all places for equal",
       .checks = {draws_are_fresh},
       .lies = {.prior_draw =
                    [](random::Stream& stream) {
                      return static_cast<std::uint32_t>(stream.uniform() * RuggedRing::k_places);
                    }}},
      {.name = "too much satisfies",
       .what = "a state next to those that satisfy counts as one",
       .checks = {stones_weigh},
       .lies = {.satisfied =
                    [](std::uint32_t place) { return place == 5 || place == 10 || place == 7; }}},
      {.name = "old density kept",
       .what = "an accepted state goes on with the density of the one before",
       .checks = {kernel_keeps},
       .step = keep_the_old_density},
      {.name = "rejected density kept",
       .what = "a state that stays goes on with the density of the rejected candidate",
       .checks = {kernel_keeps},
       .step = keep_the_rejected_density},
      {.name = "number reused in a step",
       .what = "the number that chose the proposal decides on it too",
       .checks = {kernel_keeps},
       .step = reuse_the_number},
      {.name = "number reused in the next step",
       .what = "every two steps have the same random numbers",
       .checks = {kernel_moves, kernel_keeps},
       .step = use_each_number_twice},
      {.name = "rejections not counted",
       .what = "a step proposes again until something is accepted",
       .checks = {kernel_keeps},
       .step = go_on_until_accepted},
      {.name = "temperature of the kernel",
       .what = "steps are made at another inverse temperature than that asked for",
       .checks = {kernel_keeps},
       .step = mistake_the_temperature},
  };
}

}  // namespace sleight::statistical
