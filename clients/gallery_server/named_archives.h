// The archives, folders and jobs named on a command line. Archives of jobs become files in a
// temporary folder sleight-gallery-XXXXXX. The process keeps the folder locked by flock while it
// lives. If the process was killed, the same user's next gallery removes the folder.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/base/descriptor.h"
#include "common/json/value.h"
#include "common/rpc/service.h"

namespace sleight::gallery {

/// Removes temporary folders whose galleries no longer run.
void remove_abandoned_folders(const std::string& temporary);

class NamedArchives {
 public:
  struct Job {
    rpc::JobId id{};
    std::string path{};  ///< where its archive is written
  };

  /// If a text is a number and not an existing file, the text is the id of a job, and the service
  /// must have this job. Calls `service_called` only if a job is named, so files need no service.
  /// Throws base::Error: environment if a name is neither file nor job, usage for several jobs,
  /// no_server and others from the service. Unreadable archives are reported by the page. REQUIRES:
  /// no other thread is running.
  NamedArchives(const std::vector<std::string>& texts,
                const std::function<std::string()>& service_called);
  ~NamedArchives();  ///< removes the folder
  NamedArchives(const NamedArchives&) = delete;
  NamedArchives& operator=(const NamedArchives&) = delete;

  /// Paths in the order of the texts, including the jobs' files.
  const std::vector<std::string>& paths() const { return paths_; }
  const std::vector<Job>& jobs() const { return jobs_; }
  /// The service of the jobs; empty if there are no jobs.
  const std::string& service() const { return service_; }

 private:
  std::vector<std::string> paths_;
  std::vector<Job> jobs_;
  std::string service_;
  std::string folder_;     ///< empty if there are no jobs
  base::Descriptor lock_;  ///< on the folder
};

/// Returns the terminal's message if a gallery has nothing to show. Empty if something is shown or
/// may soon be shown. `state`: the result of Gallery::state; `paths`: from the command line.
std::string nothing_to_show(const json::Value& state, const std::vector<std::string>& paths);

}  // namespace sleight::gallery
