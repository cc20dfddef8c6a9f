// A 2D ball for tests of failures. A known share of states fails, and a known share has overlapping
// starts.
//
// A state's bytes determine whether it fails. Thread safety: as for Ball2d.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "common/plan/failure.h"
#include "worker/sampling/target.h"
#include "worker/worlds/ball_2d/ball_2d.h"

namespace sleight::failing {

/// Percentages of states that give up, that exceed the work limit, and whose starts overlap.
inline constexpr std::uint64_t k_gives_up_percent = 3;
inline constexpr std::uint64_t k_work_limit_percent = 1;
inline constexpr std::uint64_t k_overlaps_percent = 2;

/// A number from 0 to 99 that depends on the state.
std::uint64_t percentile_of(base::BytesView state);

struct FailingLanding {
  worlds::ball_2d::Landing landing;
  bool starts_overlap = false;
  plan::FailurePointer failure{};
};

class FailingBall {
 public:
  using State = worlds::ball_2d::Ball2d::State;
  using Outcome = FailingLanding;

  explicit FailingBall(const worlds::ball_2d::Parameters& parameters) : ball_(parameters) {}

  State draw_prior(random::Stream& stream) const { return ball_.draw_prior(stream); }
  double log_prior(const State& state) const { return ball_.log_prior(state); }
  Outcome simulate(const State& state) const;
  double log_constraint(const Outcome& outcome) const;
  bool satisfied(const Outcome& outcome) const;
  plan::FailurePointer failure(const Outcome& outcome) const { return outcome.failure; }
  bool starts_overlap(const Outcome& outcome) const { return outcome.starts_overlap; }
  sampling::Proposal<State> propose(const State& state, std::span<const double> scales,
                                    random::Stream& stream) const {
    return ball_.propose(state, scales, stream);
  }
  bool has_scale(std::uint32_t kind) const { return ball_.has_scale(kind); }
  std::uint32_t proposal_kinds() const { return ball_.proposal_kinds(); }
  base::Bytes encode(const State& state) const { return ball_.encode(state); }
  std::size_t owned_bytes(const State&, const Outcome&) const { return 0; }
  std::optional<State> decode(base::BytesView bytes) const { return ball_.decode(bytes); }
  std::vector<double> outcome_values(const Outcome& outcome) const {
    return ball_.outcome_values(outcome.landing);
  }

 private:
  worlds::ball_2d::Ball2d ball_;
};

static_assert(sampling::ScalesProposals<FailingBall>);
static_assert(sampling::MayFail<FailingBall>);

}  // namespace sleight::failing
