// The output of a job's programs, in pieces. The keeper's two log files
// (service/keeper/bounded_log.h) form one text with numbered bytes.
//
// Byte 0 is the oldest byte that existed when the daemon first read the job's log. When `log`
// replaces `log.old`, the lost bytes keep their numbers.
//
// Thread safety: one thread.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "common/rpc/service.h"

namespace sleight::daemon {

class Logs {
 public:
  /// Throws base::Error if the log exists but can't be read.
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
