// The place where an archive is to be written: whether it can be, and whose file lies there.
//
// Thread safety: as the file system's; what lies there is read by a process of its own.
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
/// begins with none of these: somebody has put it there. By base::Error(environment) where that
/// can't be told. REQUIRES: the file is there.
void refuse_foreign_file(const std::string& output, const std::vector<std::string>& beginnings);

}  // namespace sleight::coordinator
