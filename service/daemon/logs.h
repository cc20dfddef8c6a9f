// What a job's programs have printed, in pieces: the two files that its keeper writes
// (service/keeper/bounded_log.h) as one text whose bytes are numbered.
//
// Numbers count from the oldest byte that was there when the daemon first looked at the job's log.
// When `log` takes the place of `log.old`, what was lost keeps its numbers.
//
// Thread safety: one thread.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "common/rpc/service.h"
#include "service/jobs/job.h"

namespace sleight::daemon {

class Logs {
 public:
  /// Throws base::Error where the log is there and can't be read.
  rpc::LogPiece read(const std::string& folder, const rpc::LogAsk& ask);

 private:
  struct Known {
    std::uint64_t old_inode = 0;  ///< of `log.old`
    std::uint64_t inode = 0;      ///< of `log`
    std::uint64_t base = 0;       ///< number of the first byte of `log.old`
    std::uint64_t old_size = 0;
    std::uint64_t size = 0;
  };
  std::map<std::string, Known> known_;  ///< by folder
};

}  // namespace sleight::daemon
