// What jobs may wish of Slurm, as arguments of sbatch.
//
//   account, partition, qos, time   as sbatch takes them
//   more                            further options of sbatch, "--constraint=a100 --exclusive":
//                                   words between spaces, each beginning with --
//
// Options that would break what the service relies on are refused by name, also when they are cut
// short, as sbatch takes them then too: how a job is found again (--comment, --clusters), what runs
// (--wrap, --array), where (--chdir, --output), how often (--requeue), how it is stopped
// (--signal), and how many cores and ranks it has, which follow from the job.
//
// Thread safety: pure functions.
#pragma once

#include <string>
#include <vector>

#include "service/backend/backend.h"

namespace sleight::backend {

struct SlurmWishes {
  std::vector<std::string> arguments{};
  bool says_memory = false;  ///< so the job's own memory is not asked for
};

/// The defaults' and the job's over them; of `more` the defaults' come first. Throws
/// base::Error(usage) that names what is wrong.
SlurmWishes slurm_wishes_of(const Options& defaults, const Options& options);

}  // namespace sleight::backend
