// Jobs, changes and usages as lines of JSON, as the job store saves them.
//
// A later build may add fields to the same format. So an unknown field is ignored, and a missing
// field has its type's default. If these functions can't have written a line, readers return none.
//
// Thread safety: pure functions.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "service/jobs/job.h"

namespace sleight::daemon {

std::string to_line(const jobs::Job& job);
std::string to_line(const jobs::Change& change);
std::string to_line(const jobs::Usage& usage);

std::optional<jobs::Job> job_of(std::string_view line);
std::optional<jobs::Change> change_of(std::string_view line);
std::optional<jobs::Usage> usage_of(std::string_view line);

}  // namespace sleight::daemon
