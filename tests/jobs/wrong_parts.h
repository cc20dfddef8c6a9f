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
/// Returns the input that the machine receives.
Input input_with(Mistake mistake, Input input, const Jobs& machine);
/// Returns the effects that are carried out.
std::vector<Effect> effects_with(Mistake mistake, std::vector<Effect> effects, cluster::Dice& dice);

/// Returns a choice of scenarios that reveals the mistake.
ScenarioChoice where_it_shows(Mistake mistake);

}  // namespace sleight::jobs::simulated
