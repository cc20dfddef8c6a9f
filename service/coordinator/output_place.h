// Checks an archive's output path: whether it is writable, and which file is already there. A
// separate process reads the existing file. Thread safety: the same as the file system's.
#pragma once

#include <string>
#include <vector>

#include "common/base/file_system.h"
#include "common/request/direction_request.h"

namespace sleight::coordinator {

/// Throws base::Error if no archive can be written to `output`. A run then fails at its start, not
/// after an hour of computing. ExitCode::usage: `output` names no file.
void refuse_unusable_place(const std::string& output, base::FileSystem& files);

/// Returns the possible beginnings of the request text in an archive of this run. The archive may
/// have only finds.
std::vector<std::string> beginnings_of(const request::DirectionRequest& request);

/// Throws base::Error(conflict) if somebody else put the file there: it isn't an archive, or its
/// request has none of the `beginnings`. Throws base::Error(environment) if the file can't be read.
/// REQUIRES: the file exists.
void refuse_foreign_file(const std::string& output, const std::vector<std::string>& beginnings);

}  // namespace sleight::coordinator
