// Which archives a list of files and folders means.
#pragma once

#include <string>
#include <vector>

namespace sleight::gallery {

struct ListedFiles {
  struct File {
    std::string path{};
    std::string name{};  ///< without its folder, as people see it
  };
  struct LeftOut {
    std::string name{};
    std::string reason{};
    friend bool operator==(const LeftOut&, const LeftOut&) = default;
  };
  std::vector<File> files{};
  std::vector<LeftOut> left_out{};
};

/// Files as they are named, whether they are there or not; of folders what ends in ".h5", by name.
/// A link in a folder that leads out of it is left out: whoever may write there would choose what
/// somebody else shows.
ListedFiles listed_files(const std::vector<std::string>& paths);

}  // namespace sleight::gallery
