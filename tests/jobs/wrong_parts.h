// What a wrong service does in the place of the right one (mistakes.h). With Mistake::none all of
// this changes nothing.
#pragma once

#include <vector>

#include "service/jobs/jobs.h"
#include "tests/cluster/dice.h"
#include "tests/jobs/scenario.h"

namespace sleight::jobs::simulated {

Options options_with(Mistake mistake, Options options);
/// What a daemon that begins takes from the store.
Restored restored_with(Mistake mistake, Restored restored);
/// What the machine takes an input for.
Input input_with(Mistake mistake, Input input, const Jobs& machine);
/// What is made of a step's effects.
std::vector<Effect> effects_with(Mistake mistake, std::vector<Effect> effects, cluster::Dice& dice);

/// What goes wrong where the mistake shows.
ScenarioChoice where_it_shows(Mistake mistake);

}  // namespace sleight::jobs::simulated
