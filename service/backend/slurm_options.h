// Options that jobs can set for Slurm, as arguments of sbatch.
//
//   `account`, `partition`, `qos` and `time` are sbatch's options of the same names.
//   `more` has further options of sbatch, separated by spaces, each beginning with --, such as
//          "--constraint=a100 --exclusive".
//
// Options that would break the service are refused by name, including abbreviations that sbatch
// accepts. Refused options include options for finding a job again (--comment, --clusters), for the
// command (--wrap, --array), for its files (--chdir, --output), for restarts (--requeue) and for
// stopping (--signal). Options for a job's cores and ranks are refused too.
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

/// Combines the defaults with the job's options, which take precedence. In `more`, the defaults'
/// words come before the job's words. Throws base::Error(usage) that names the wrong option.
SlurmWishes slurm_wishes_of(const Options& defaults, const Options& options);

}  // namespace sleight::backend
