// Options that jobs can set for Slurm, as arguments of sbatch.
//
//   `account`, `partition`, `qos`, `time` are those of sbatch.
//   `more` has further options of sbatch, "--constraint=a100 --exclusive": words separated by
//          spaces, each beginning with --.
//
// Options that would break the service are refused by name, including abbreviations that sbatch
// accepts. Refused options include those for finding a job again (--comment, --clusters), for the
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

/// Combines the defaults with the job's options, which take precedence. In `more`, the default
/// words precede the job's. Throws base::Error(usage) that names the wrong option.
SlurmWishes slurm_wishes_of(const Options& defaults, const Options& options);

}  // namespace sleight::backend
