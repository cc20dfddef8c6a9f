// Starts a program as a child that does not outlive whoever starts it: an attempt's, by its keeper;
// a tool (tool.h).
//
// The child is killed by the kernel when this process ends, however that ends (PR_SET_PDEATHSIG).
// It has a session of its own, no terminal, no descriptor but the standard ones, no core dumps
// and the environment that it is given.
//
// Thread safety: call from a thread that lives as long as the child may: the kernel watches the
// thread that forked, not the process.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "common/base/result.h"
#include "service/keeper/moments.h"

namespace sleight::keeper {

struct ProgramStart {
  std::vector<std::string> command{};  ///< not empty; a name without a slash is looked for on PATH
  std::vector<std::string> environment{};
  int input = -1;               ///< becomes its stdin; -1: there is nothing to read
  int output = -1;              ///< becomes its stdout
  int words = -1;               ///< becomes its stderr; -1: as output
  bool yields = false;          ///< it runs at a low priority
  bool blocks_sigterm = false;  ///< it does not get SIGTERM, nor do those that it starts
};

/// Returns once the program runs; or why it can't be started, and then there is no child.
base::Result<pid_t, std::string> start_program(const ProgramStart& start, Moments& moments);

/// All arguments as exec takes them; valid as long as `words` is and does not change.
std::vector<char*> pointers_to(std::vector<std::string>& words);

}  // namespace sleight::keeper
