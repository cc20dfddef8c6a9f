// Checks the output path of an archive: whether it is writable, and which file is already there.
// Thread safety: that of the file system. A separate process reads the existing file.
#pragma once

#include <string>
#include <vector>

#include "common/base/file_system.h"
#include "common/request/direction_request.h"

namespace sleight::coordinator {

/// Throws base::Error now, rather than after an hour of computing, if no archive can be written
/// there. ExitCode::usage: `output` names no file.
void refuse_unusable_place(const std::string& output, base::FileSystem& files);

/// Returns how the request in an archive of this run may begin, also with only finds.
std::vector<std::string> beginnings_of(const request::DirectionRequest& request);

/// Throws base::Error(conflict) if the file is not an archive, or if its request begins with none
/// of `beginnings`, because somebody else put the file there. Throws base::Error(environment) if
/// the file can't be read. REQUIRES: the file exists.
void refuse_foreign_file(const std::string& output, const std::vector<std::string>& beginnings);

}  // namespace sleight::coordinator
