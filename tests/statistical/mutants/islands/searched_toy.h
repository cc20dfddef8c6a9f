// The staged toy and everything else that a run's visits and searches require of a world.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/random/discrete_distributions.h"
#include "tests/statistical/support/staged_toy.h"
#include "worker/run/search_start.h"

namespace sleight::statistical {

struct SearchedToy : StagedToy {
  /// A try is a uniform choice. The try is promising if the walker has not fallen.
  struct Builder {
    using Prefix = StagedToy::Prefix;
    std::uint32_t stages() const { return k_stages; }
    static sampling::SearchLimits limits() { return {}; }
    Prefix start(random::Stream& stream) const {
      const Ground ground = StagedToy{}.draw_ground({}, stream);
      return StagedToy{}.no_stages({}, ground);
    }
    std::optional<Prefix> attempt(const Prefix& prefix, std::uint32_t /*stage*/,
                                  sampling::SearchEffort& effort, random::Stream& stream) const {
      const auto choice =
          static_cast<std::uint32_t>(random::UniformInteger{.count = k_choices}.draw(stream));
      Prefix longer = prefix;
      StagedToy{}.extend_by({}, choice, longer);
      ++effort.simulations;
      return longer.outcome.fallen ? std::nullopt : std::optional(longer);
    }
    bool is_solution(const Prefix& prefix) const { return StagedToy{}.satisfied(prefix.outcome); }
    State state_of(const Prefix& prefix) const { return prefix.digits; }
    Outcome outcome_of(const Prefix& prefix) const { return prefix.outcome; }
  };

  Guide learn(std::uint64_t /*seed*/) const { return {}; }
  std::span<const plan::FailurePointer> failures_of(const Guide&) const { return {}; }
  Builder builder(const Guide&) const { return {}; }
  Outcome simulate_to_rest(const State& state) const { return simulate(state); }
  std::vector<sampling::BurnInValue> burn_in_values() const { return {}; }
  std::vector<double> burn_in_values_of(const State&, const Outcome&) const { return {}; }
  std::string stage_name(std::uint32_t) const { return "step"; }
};
static_assert(run::StagedWorld<SearchedToy>);

}  // namespace sleight::statistical
