#include "tests/failing/failing_ball.h"

#include <limits>

namespace sleight::failing {

std::uint64_t percentile_of(base::BytesView state) {
  // Use FNV-1a, so that the result depends on all bits of the state.
  std::uint64_t hash = 14695981039346656037U;
  for (const std::byte byte : state)
    hash = (hash ^ static_cast<std::uint64_t>(byte)) * 1099511628211U;
  return (hash >> 32U) % 100;
}

FailingLanding FailingBall::simulate(const State& state) const {
  const base::Bytes bytes = ball_.encode(state);
  const std::uint64_t percentile = percentile_of(bytes);
  FailingLanding outcome{.landing = ball_.simulate(state)};
  const auto fail = [&](plan::FailureKind kind, std::string message) {
    outcome.failure = std::make_shared<const plan::SimulationFailure>(
        plan::SimulationFailure{.kind = kind, .message = std::move(message), .state = bytes});
  };
  constexpr std::uint64_t k_second = k_gives_up_percent + k_work_limit_percent;
  if (percentile < k_gives_up_percent)
    fail(plan::FailureKind::search_gave_up, "the ball: planted, at tick 7 (6.5e-09 s)");
  else if (percentile < k_second)
    fail(plan::FailureKind::work_limit, "the ball: planted, more work than 10 events");
  else if (percentile < k_second + k_overlaps_percent)
    outcome.starts_overlap = true;
  return outcome;
}

bool FailingBall::satisfied(const Outcome& outcome) const {
  return !outcome.starts_overlap && ball_.satisfied(outcome.landing);
}

double FailingBall::log_constraint(const Outcome& outcome) const {
  if (outcome.starts_overlap) return -std::numeric_limits<double>::infinity();
  return ball_.log_constraint(outcome.landing);
}

}  // namespace sleight::failing
