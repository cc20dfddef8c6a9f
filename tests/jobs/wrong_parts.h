// The wrong behaviour of each mistake (mistakes.h). With Mistake::none, nothing changes.
#pragma once

#include <vector>

#include "service/jobs/jobs.h"
#include "tests/cluster/dice.h"
#include "tests/jobs/scenario.h"

namespace sleight::jobs::simulated {

Options options_with(Mistake mistake, Options options);
/// What a restarted daemon reads from the store.
Restored restored_with(Mistake mistake, Restored restored);
/// The input that the machine receives.
Input input_with(Mistake mistake, Input input, const Jobs& machine);
/// The effects that are carried out.
std::vector<Effect> effects_with(Mistake mistake, std::vector<Effect> effects, cluster::Dice& dice);

/// A choice of scenarios in which the mistake shows.
ScenarioChoice where_it_shows(Mistake mistake);

}  // namespace sleight::jobs::simulated
