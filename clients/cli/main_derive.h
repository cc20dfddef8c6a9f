// `sleight archive derive`: makes the archive of an unfinished run from its run store.
#pragma once

#include <string>

namespace sleight::programs {

struct DeriveArguments {
  std::string folder;  ///< the run's folder, such as ball.h5.run
  std::string output;
  bool json = false;
};

/// Makes the archive, prints its content and returns the exit code.
int derive(const DeriveArguments& arguments);

}  // namespace sleight::programs
