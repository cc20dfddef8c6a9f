// The groups that say what a run's animations look like and what its prior is: /scene, /prior and
// /sample_stats_prior. Private to common/archive.
#pragma once

#include "common/archive/model.h"
#include "common/archive/run_view.h"
#include "common/archive/world_layout.h"

namespace sleight::archive {

/// REQUIRES: fault_of(scene) finds none.
void write_scene(const scene::Scene& scene, Sink& sink);

/// The view's draws from the prior, as one chain.
void write_prior(const RunView& view, const StateReader& reader, Sink& sink);

}  // namespace sleight::archive
