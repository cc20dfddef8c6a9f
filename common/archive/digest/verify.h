// Whether an archive is what docs/ARCHIVE_FORMAT.md says, as far as its content can show.
//
// Checked are: the attributes and datasets with their types and dimensions; the stored digest
// against the recomputed one; and what must hold between the values, among them
//   lp = log_prior + log_constraint, bit for bit; 0 <= accepted <= proposed;
//   draws are 0, thin, 2 thin, ... and every scan up to the cut;
//   kept animations are in logical order, within keep_max and keep_per_lineage, satisfied, and
//   equal to their scan's row in /sample_stats; their segments follow one another without gap;
//   the scene is such, and so are the motions of its bodies.
#pragma once

#include <string>
#include <vector>

#include "common/archive/model.h"

namespace sleight::archive {

/// One sentence for each kind of fault, with the first place where it was found; empty for a sound
/// archive. Values are only looked at when the structure is right. Reads everything once or twice,
/// in batches. Throws what the source throws where data can't be read at all.
std::vector<std::string> verify(const Source& source);

}  // namespace sleight::archive
