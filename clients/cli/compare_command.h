// `sleight compare`: in what two archives differ, and whether their animations do.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace sleight::cli {

struct CompareOptions {
  std::string first{};
  std::string second{};
  std::uint64_t groups = 8;
  bool json = false;
};

/// Returns the exit code; throws base::Error. Both archives must be readable.
int compare_archives(const CompareOptions& options);

/// A line of one request, or of both, that the other has otherwise.
struct OtherLine {
  std::string
      key{};  ///< "stop.scans"; of arrays of tables with the number: "constraint.place[1].x_mm"
  std::string first{};  ///< its value there; empty: it is not there
  std::string second{};
};

/// In what two normalised requests differ, by their keys, in the order of the first.
std::vector<OtherLine> other_lines(const std::string& first, const std::string& second);

}  // namespace sleight::cli
