// Parses squeue's output into attempts.
//
// Each row is a job: number, state, reason and comment, separated by '|'. The comment is last,
// because it may contain anything. A job is ignored if its comment isn't an attempt's name.
//
// Thread safety: pure functions.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "service/backend/backend.h"

namespace sleight::backend {

inline constexpr const char* k_squeue_format = "%i|%T|%r|%k";

struct SlurmJob {
  std::string id{};
  Seen seen{};
  bool operator==(const SlurmJob&) const = default;
};

/// Slurm jobs of each attempt, by ascending number. An attempt may have several jobs if sbatch's
/// answer was lost.
using SlurmQueue = std::map<AttemptName, std::vector<SlurmJob>>;

/// Ignores unreadable rows.
SlurmQueue slurm_queue_of(std::string_view text);

/// Returns the attempt's running job. If no job runs, returns a waiting job; if no job waits, the
/// newest job. REQUIRES: not empty.
const SlurmJob& telling_one(const std::vector<SlurmJob>& jobs);

/// Translates a Slurm job's state into an attempt's state.
Seen seen_of_slurm(std::string_view state, std::string_view reason);

/// Returns the job number in the output of `sbatch --parsable`. Empty: none.
std::string slurm_number_in(std::string_view text);

/// Returns whether this error of a Slurm command means that Slurm's controller doesn't answer.
bool says_away(std::string_view words);

}  // namespace sleight::backend
