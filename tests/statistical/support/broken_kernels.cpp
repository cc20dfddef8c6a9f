#include "tests/statistical/support/broken_kernels.h"

#include <limits>
#include <utility>

#include "common/random/distributions.h"

namespace sleight::statistical {
namespace {

/// The ball with a wrong proposal. Everything else is inherited from the ball.
class BrokenProposal {
 public:
  using State = Ball::State;
  using Outcome = Ball::Outcome;

  BrokenProposal(const Ball& ball, Bug bug, double beta) : ball_(ball), bug_(bug), beta_(beta) {}

  State draw_prior(random::Stream& stream) const { return ball_.draw_prior(stream); }
  double log_prior(const State& state) const { return ball_.log_prior(state); }
  Outcome simulate(const State& state) const { return ball_.simulate(state); }
  double log_constraint(const Outcome& outcome) const { return ball_.log_constraint(outcome); }
  bool satisfied(const Outcome& outcome) const { return ball_.satisfied(outcome); }
  std::uint32_t proposal_kinds() const { return 1; }

  sampling::Proposal<State> propose(const State& state, random::Stream& stream) const {
    sampling::Proposal<State> proposal = ball_.propose(state, {}, stream);
    State& candidate = proposal.candidate;
    switch (bug_) {
      case Bug::always_accepts:
        proposal.log_q_ratio = std::numeric_limits<double>::infinity();
        break;
      case Bug::ratio_inverted:
        proposal.log_q_ratio = -2 * log_ratio(state, candidate);
        break;
      case Bug::prior_forgotten:
        proposal.log_q_ratio = log_prior(state) - log_prior(candidate);
        break;
      case Bug::independence_draw_as_symmetric:
        candidate = ball_.draw_prior(stream);
        break;
      case Bug::lopsided_offset:
        candidate[0] += 0.25 * ball_.parameters().proposal.change_half_width_rad;
        break;
      case Bug::shrinking_proposal:
        for (double& angle : candidate)
          angle *= 0.9;
        break;
      default:
        break;
    }
    return proposal;
  }

 private:
  double log_ratio(const State& from, const State& to) const {
    const auto log_density = [&](const State& state) {
      return log_prior(state) + beta_ * log_constraint(simulate(state));
    };
    return log_density(to) - log_density(from);
  }

  const Ball& ball_;
  Bug bug_;
  double beta_;
};

/// Makes a step in which the first number of the proposal's stream also decides about acceptance.
void step_reusing_a_number(const Ball& ball, double beta, const sampling::ChainStreams& streams,
                           std::uint64_t iteration, BallSample& current) {
  random::Stream proposal_stream = streams.at(random::Purpose::proposal, iteration);
  auto proposal = ball.propose(current.state, {}, proposal_stream);
  BallSample candidate = sampling::evaluate(ball, proposal.candidate);
  const double log_ratio =
      sampling::log_acceptance_ratio(current.log_prior, current.log_constraint, candidate.log_prior,
                                     candidate.log_constraint, beta, proposal.log_q_ratio);
  random::Stream again = streams.at(random::Purpose::proposal, iteration);
  if (math::log(again.uniform()) < log_ratio) current = std::move(candidate);
}

}  // namespace

const char* name_of(Bug bug) {
  switch (bug) {
    case Bug::none:
      return "none";
    case Bug::always_accepts:
      return "always accepts";
    case Bug::ratio_inverted:
      return "ratio inverted";
    case Bug::prior_forgotten:
      return "prior forgotten";
    case Bug::constraint_forgotten:
      return "constraint forgotten";
    case Bug::wrong_temperature:
      return "wrong temperature";
    case Bug::independence_draw_as_symmetric:
      return "independence draw as symmetric";
    case Bug::lopsided_offset:
      return "lopsided offset";
    case Bug::shrinking_proposal:
      return "shrinking proposal";
    case Bug::old_density_kept:
      return "old density kept";
    case Bug::random_number_reused:
      return "random number reused";
  }
  return "?";
}

void step(const Ball& ball, Bug bug, double beta, const sampling::ChainStreams& streams,
          std::uint64_t iteration, BallSample& current) {
  switch (bug) {
    case Bug::none:
      sampling::metropolis_hastings_step(ball, beta, streams, iteration, current);
      return;
    case Bug::constraint_forgotten:
      sampling::metropolis_hastings_step(ball, 0.0, streams, iteration, current);
      return;
    case Bug::wrong_temperature:
      sampling::metropolis_hastings_step(ball, 0.7 * beta, streams, iteration, current);
      return;
    case Bug::old_density_kept: {
      const double old_log_constraint = current.log_constraint;
      sampling::metropolis_hastings_step(ball, beta, streams, iteration, current);
      current.log_constraint = old_log_constraint;
      return;
    }
    case Bug::random_number_reused:
      step_reusing_a_number(ball, beta, streams, iteration, current);
      return;
    default: {
      const BrokenProposal broken(ball, bug, beta);
      sampling::Sample<BrokenProposal> sample{current.state, current.outcome, current.log_prior,
                                              current.log_constraint};
      sampling::metropolis_hastings_step(broken, beta, streams, iteration, sample);
      current = {sample.state, sample.outcome, sample.log_prior, sample.log_constraint};
    }
  }
}

}  // namespace sleight::statistical
