// `sleight compare`: in what two archives differ, and whether their animations do.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

namespace sleight::cli {

struct CompareOptions {
  std::string first{};
  std::string second{};
  std::uint64_t groups = 8;
  bool json = false;
};

/// Returns the exit code; throws base::Error. Both archives must be readable.
int compare_archives(const CompareOptions& options);

}  // namespace sleight::cli
