// Jobs, changes and usages as lines of JSON: what the job store keeps of them.
//
// A field that is missing has its type's default, and one that is not known is passed over: a later
// build of the same store format may add some. Everything else that was not written here is none.
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
