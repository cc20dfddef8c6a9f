// Converts an archive's animations to tables, and to models with metadata.
#pragma once

#include <iosfwd>
#include <span>
#include <string>

#include "clients/browse/archives/animation_ids.h"
#include "clients/export/document.h"
#include "common/archive/model.h"
#include "common/scene/scene.h"

namespace sleight::cli {

/// Returns metadata about a whole file: world, request, run_id, results_version. If the archive has
/// a warning, the metadata include it.
gltf::Extras extras_of(const archive::Source& source);

/// Returns an animation with its motion, its own parts of the scene, and metadata. Metadata are id,
/// chain, draw and lineage (or start), in_proportion, duration_s, log densities and outcomes.
/// Throws base::Error(bad_archive) if the motion is invalid.
gltf::Clip clip_of(const archive::Source& source, const scene::Scene& scene,
                   const browse::AnimationId& id);

/// Writes a table of "animations", "segments" or "points" as CSV. The table has these animations in
/// this order; the first column has their ids. Finds and animations of chains have different
/// columns. A mixed table has the columns of both and leaves fields empty. REQUIRES: at least one
/// animation.
void write_animations_csv(const archive::Source& source, std::span<const browse::AnimationId> ids,
                          const std::string& table, std::ostream& out);

}  // namespace sleight::cli
