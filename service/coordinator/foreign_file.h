// What lies in the place of an archive that is to be written: ours, or somebody's.
//
// Thread safety: as guarded (archive/hdf5/guarded.h), which reads it in a child.
#pragma once

#include <string>
#include <vector>

namespace sleight::coordinator {

/// Refuses, by base::Error(conflict), to replace a file that is no archive, or one whose request
/// begins with none of these: somebody has put it there. REQUIRES: the file is there.
void refuse_foreign_file(const std::string& output, const std::vector<std::string>& beginnings);

}  // namespace sleight::coordinator
