// A draw from a world's prior, for archives: what samples are compared with.
#pragma once

#include <cstdint>

#include "common/archive/world_layout.h"
#include "common/random/stream.h"
#include "worker/sampling/target.h"

namespace sleight::worlds {

/// The nth, from a stream of its own. `variables_of` gives the values of all variables of a state.
template <sampling::Target World, class VariablesOf>
archive::PriorDraw prior_draw(const World& world, const archive::WorldLayout& layout,
                              std::uint64_t nth, const VariablesOf& variables_of) {
  random::Stream stream({.purpose = random::Purpose::prior_draw}, nth);
  const auto sample = sampling::evaluate(world, world.draw_prior(stream));
  return {.variables = archive::prior_values(layout, variables_of(sample.state)),
          .outcome = world.outcome_values(sample.outcome),
          .log_prior = sample.log_prior,
          .log_constraint = sample.log_constraint,
          .satisfied = world.satisfied(sample.outcome)};
}

}  // namespace sleight::worlds
