// The place where an archive is to be written: whether it can be, and whose file lies there.
//
// Thread safety: as guarded (archive/hdf5/guarded.h), which reads what lies there in a child.
#pragma once

#include <string>
#include <vector>

#include "common/base/file_system.h"
#include "common/request/direction_request.h"

namespace sleight::coordinator {

/// Finds out now, not after an hour of computing, that no archive can be written there: throws
/// base::Error, usage where `output` names no file.
void refuse_unusable_place(const std::string& output, base::FileSystem& files);

/// With which the request of an archive of this run begins: of one that has finds alone, too.
std::vector<std::string> beginnings_of(const request::DirectionRequest& request);

/// Refuses, by base::Error(conflict), to replace a file that is no archive, or one whose request
/// begins with none of these: somebody has put it there. REQUIRES: the file is there.
void refuse_foreign_file(const std::string& output, const std::vector<std::string>& beginnings);

}  // namespace sleight::coordinator
