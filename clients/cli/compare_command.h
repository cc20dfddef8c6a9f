// `sleight compare`: how two archives and their animations differ.
#pragma once

#include <cstdint>
#include <string>

namespace sleight::cli {

struct CompareOptions {
  std::string first{};
  std::string second{};
  std::uint64_t groups = 8;
  bool json = false;
};

/// Returns the exit code. Throws base::Error if either archive can't be read.
int compare_archives(const CompareOptions& options);

}  // namespace sleight::cli
