// Starts an attempt's program or a tool as a child. The child doesn't outlive its starter.
//
// The kernel kills the child when this process ends for any reason (PR_SET_PDEATHSIG). The child
// has its own session, the given environment and only standard descriptors. The child has no
// terminal and leaves no core dump.
//
// Thread safety: the calling thread must outlive the child, because the kernel watches the thread.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "common/base/result.h"
#include "service/keeper/moments.h"

namespace sleight::keeper {

struct ProgramStart {
  std::vector<std::string> command{};  ///< not empty; a name without a slash is searched on PATH
  std::vector<std::string> environment{};
  int input = -1;               ///< becomes its stdin; -1: empty
  int output = -1;              ///< becomes its stdout
  int words = -1;               ///< becomes its stderr; -1: same as output
  bool yields = false;          ///< run at low priority
  bool blocks_sigterm = false;  ///< block SIGTERM in the program and its children
};

/// Returns once the program runs. If starting fails, there is no child, and the reason is returned.
base::Result<pid_t, std::string> start_program(const ProgramStart& start, Moments& moments);

/// Returns pointers to the words, as exec expects them. Valid until `words` changes.
std::vector<char*> pointers_to(std::vector<std::string>& words);

}  // namespace sleight::keeper
