// Finds the archives in a list of files and folders.
#pragma once

#include <string>
#include <vector>

namespace sleight::gallery {

struct ListedFiles {
  struct File {
    std::string path{};
    std::string name{};  ///< the displayed name, without the folder
  };
  struct LeftOut {
    std::string name{};
    std::string reason{};
    friend bool operator==(const LeftOut&, const LeftOut&) = default;
  };
  std::vector<File> files{};
  std::vector<LeftOut> left_out{};
};

/// Named files are listed even if they don't exist. A folder's files ending in ".h5" are listed,
/// ordered by name. Links that point outside their folder are skipped: otherwise, anyone who can
/// write to the folder could choose what another user's gallery shows.
ListedFiles listed_files(const std::vector<std::string>& paths);

}  // namespace sleight::gallery
