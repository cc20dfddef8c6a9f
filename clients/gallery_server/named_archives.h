// What a command line names to be shown: archives, folders, and jobs of the service, whose archives
// come as files into a folder of this object's own.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/rpc/service.h"

namespace sleight::gallery {

class NamedArchives {
 public:
  struct Job {
    rpc::JobId id{};
    std::string path{};  ///< where its archive comes to lie
  };

  /// A text that is no file here and reads as a job's number is a job, which the service is asked
  /// for. Throws base::Error: usage where a name is neither, no_server and others of the service.
  /// What is there and can't be read is told on the page. REQUIRES: no other thread runs.
  NamedArchives(const std::vector<std::string>& texts, const std::string& socket);
  ~NamedArchives();  ///< removes the folder
  NamedArchives(const NamedArchives&) = delete;
  NamedArchives& operator=(const NamedArchives&) = delete;

  /// In the order of the texts, jobs' files among them.
  const std::vector<std::string>& paths() const { return paths_; }
  const std::vector<Job>& jobs() const { return jobs_; }

 private:
  std::vector<std::string> paths_;
  std::vector<Job> jobs_;
  std::string folder_;  ///< empty: there are no jobs
};

}  // namespace sleight::gallery
