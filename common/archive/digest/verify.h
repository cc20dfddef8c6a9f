// Checks whether an archive conforms to docs/ARCHIVE_FORMAT.md, as far as its content shows.
//
// The checks cover the types and dimensions of attributes and datasets. The stored digest is
// compared with a recomputed one. Relations between the values are checked, such as:
//   - lp = log_prior + log_constraint, bit for bit; 0 <= accepted <= proposed;
//   - draws are 0, thin, 2 thin, ... and every scan up to the cut;
//   - kept animations are satisfied, in logical order, within keep_max and keep_per_lineage, and
//     equal to their scan's row in /sample_stats; their segments are contiguous;
//   - the scene and the motions of its bodies are valid.
#pragma once

#include <string>
#include <vector>

#include "common/archive/model.h"

namespace sleight::archive {

/// Returns one sentence for each kind of fault. The sentence says where the fault first occurs.
/// Empty: the archive is valid. Checks values only if check_structure finds no fault. Reads the
/// archive once or twice, in batches. If data can't be read, the source's exception is passed on.
std::vector<std::string> verify(const Source& source);

}  // namespace sleight::archive
