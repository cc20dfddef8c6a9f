// Writes the groups for the scene and the prior: /scene, /prior and /sample_stats_prior. Private to
// common/archive.
#pragma once

#include "common/archive/model.h"
#include "common/archive/run_view.h"
#include "common/archive/world_layout.h"

namespace sleight::archive {

/// REQUIRES: fault_of(scene) is empty.
void write_scene(const scene::Scene& scene, Sink& sink);

/// Writes the view's draws from the prior, as one chain.
void write_prior(const RunView& view, const StateReader& reader, Sink& sink);

}  // namespace sleight::archive
