// Options that jobs can set for Slurm, as arguments of sbatch.
//
//   account, partition, qos, time   as for sbatch
//   more                            further options of sbatch, "--constraint=a100 --exclusive":
//                                   words between spaces, each beginning with --
//
// Options that would break the service are refused by name, including abbreviations that sbatch
// accepts. They control how a job is found again (--comment, --clusters), what runs (--wrap,
// --array), where (--chdir, --output), how often (--requeue), how it is stopped (--signal), and its
// cores and ranks, which follow from the job.
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
