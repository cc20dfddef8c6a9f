// What squeue says, as attempts.
//
// One row a job: number, state, reason and comment, with '|' between. The comment stands last, as
// it may hold anything; jobs whose comment names no attempt are other people's business.
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

/// Of an attempt there may be several, where an answer was lost: by number, ascending.
using SlurmQueue = std::map<AttemptName, std::vector<SlurmJob>>;

/// Rows that can't be read are passed over.
SlurmQueue slurm_queue_of(std::string_view text);

/// The one that says most of the attempt: one that runs, else that waits, else the newest.
/// REQUIRES: not empty.
const SlurmJob& telling_one(const std::vector<SlurmJob>& jobs);

/// What a state of Slurm's means for an attempt.
Seen seen_of_slurm(std::string_view state, std::string_view reason);

/// The number in an answer of `sbatch --parsable`; empty: there is none.
std::string slurm_number_in(std::string_view text);

/// Whether words of one of Slurm's programs say that its controller doesn't answer.
bool says_away(std::string_view words);

}  // namespace sleight::backend
