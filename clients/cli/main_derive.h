// `sleight archive derive`: the archive of a run so far, out of its store.
#pragma once

#include <string>

namespace sleight::programs {

struct DeriveArguments {
  std::string folder;  ///< of the run: ball.h5.run
  std::string output;
  bool json = false;
};

/// Derives, and says what the archive holds; the exit code.
int derive(const DeriveArguments& arguments);

}  // namespace sleight::programs
