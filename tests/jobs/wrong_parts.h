// Implements the mistakes of mistakes.h. Mistake::none changes nothing.
#pragma once

#include <vector>

#include "service/jobs/jobs.h"
#include "tests/cluster/dice.h"
#include "tests/jobs/scenario.h"

namespace sleight::jobs::simulated {

Options options_with(Mistake mistake, Options options);
/// Returns what a daemon with this mistake reads from the store.
Restored restored_with(Mistake mistake, Restored restored);
Input input_with(Mistake mistake, Input input, const Jobs& machine);
std::vector<Effect> effects_with(Mistake mistake, std::vector<Effect> effects, cluster::Dice& dice);

/// Returns the choice of scenarios in which the mistake is noticed.
ScenarioChoice where_it_shows(Mistake mistake);

}  // namespace sleight::jobs::simulated
