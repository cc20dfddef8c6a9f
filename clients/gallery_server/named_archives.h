// What a command line names to be shown: archives, folders, and jobs of the service, whose archives
// come as files into a folder of this object's own: sleight-gallery-XXXXXX among the temporary
// files. The folder is locked by flock while its process lives; one whose process was killed is
// removed by the next gallery of the same user.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/base/descriptor.h"
#include "common/rpc/service.h"

namespace sleight::gallery {

/// Removes folders of jobs' archives of galleries that are no more.
void remove_abandoned_folders(const std::string& temporary);

class NamedArchives {
 public:
  struct Job {
    rpc::JobId id{};
    std::string path{};  ///< where its archive comes to lie
  };

  /// A text that is no file here and reads as a job's number is a job, which the service is asked
  /// for; `service_called` is asked then alone, so that files need no service. Throws base::Error:
  /// environment where a name is neither, usage where it is several jobs, no_server and others of
  /// the service. The page names what can't be read. REQUIRES: no other thread
  /// runs.
  NamedArchives(const std::vector<std::string>& texts,
                const std::function<std::string()>& service_called);
  ~NamedArchives();  ///< removes the folder
  NamedArchives(const NamedArchives&) = delete;
  NamedArchives& operator=(const NamedArchives&) = delete;

  /// In the order of the texts, jobs' files among them.
  const std::vector<std::string>& paths() const { return paths_; }
  const std::vector<Job>& jobs() const { return jobs_; }
  /// What is called for the jobs; empty: there are none.
  const std::string& service() const { return service_; }

 private:
  std::vector<std::string> paths_;
  std::vector<Job> jobs_;
  std::string service_;
  std::string folder_;     ///< empty: there are no jobs
  base::Descriptor lock_;  ///< of the folder
};

}  // namespace sleight::gallery
