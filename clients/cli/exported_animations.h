// An archive's animations as what exporters write: models with their metadata, and tables.
#pragma once

#include <iosfwd>
#include <span>
#include <string>

#include "clients/browse/archives/animation_ids.h"
#include "clients/export/document.h"
#include "common/archive/model.h"
#include "common/scene/scene.h"

namespace sleight::cli {

/// What stands in a file about all its animations: world, request, run_id, results_version and,
/// where there is one, the archive's warning.
gltf::Extras extras_of(const archive::Source& source);

/// The animation with its motion, what is its own of the scene, and about it: id, chain, draw and
/// lineage (or start), in_proportion, duration_s, log densities and outcomes. Throws
/// base::Error(bad_archive) on what can be no motion.
gltf::Clip clip_of(const archive::Source& source, const scene::Scene& scene,
                   const browse::AnimationId& id);

/// A table of "animations", "segments" or "points" as CSV, of these animations in this order, with
/// their ids as first column. Finds have other columns than animations of chains: where both are
/// there, the table has all, and a field that a row has not is empty. REQUIRES: an animation at
/// least.
void write_animations_csv(const archive::Source& source, std::span<const browse::AnimationId> ids,
                          const std::string& table, std::ostream& out);

}  // namespace sleight::cli
