// Options that jobs can set for Slurm, as arguments of sbatch.
//
//   `account`, `partition`, `qos`, `time` are those of sbatch.
//   `more` has further options of sbatch, "--constraint=a100 --exclusive": words separated by
//   spaces, each beginning with --.
//
// Options that would break the service are refused by name, including abbreviations that sbatch
// accepts. These options control how a job is found again (--comment, --clusters), what runs
// (--wrap, --array), where (--chdir, --output), how often (--requeue) and how it is stopped
// (--signal). A job's cores and ranks also can't be set here.
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

/// Combines the defaults with the job's options, which take precedence; for `more`, the defaults
/// come first. Throws base::Error(usage) that names the wrong option.
SlurmWishes slurm_wishes_of(const Options& defaults, const Options& options);

}  // namespace sleight::backend
