// Options that jobs can set for Slurm, as arguments of sbatch.
//
//   `account`, `partition`, `qos` and `time` are sbatch's options of the same names.
//   `more` has further options of sbatch, such as "--constraint=a100 --exclusive". Each option
//          begins with --; spaces separate the options.
//
// Options that would break the service are refused by name, including abbreviations that sbatch
// accepts. For example, the refused options find a job again (--comment, --clusters), or set its
// command (--wrap, --array), files (--chdir, --output), restarts (--requeue), stopping (--signal),
// cores or ranks.
//
// Thread safety: pure functions.
#pragma once

#include <string>
#include <vector>

#include "service/backend/backend.h"

namespace sleight::backend {

struct SlurmWishes {
  std::vector<std::string> arguments{};
  bool says_memory = false;  ///< so the job's own memory isn't requested
};

/// Combines the defaults with the job's options. The job's options take precedence. In `more`, the
/// defaults' words come before the job's words. If an option is wrong, throws base::Error(usage)
/// that names it.
SlurmWishes slurm_wishes_of(const Options& defaults, const Options& options);

}  // namespace sleight::backend
