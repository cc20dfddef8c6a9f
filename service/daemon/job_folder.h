// Paths in a job's folder, and the daemon's operations on them. The keeper (service/keeper) writes
// the other files. Thread safety: one thread at a time per folder.
#pragma once

#include <cstdint>
#include <string>

#include "common/base/file_system.h"
#include "service/jobs/job.h"

namespace sleight::daemon {

class JobFolders {
 public:
  /// `state`: absolute path of the state folder.
  explicit JobFolders(std::string state) : state_(std::move(state)) {}

  std::string all() const { return state_ + "/jobs"; }
  /// Folder of files that clients fetch. A daemon empties the folder when it starts.
  std::string fetched() const { return state_ + "/fetched"; }
  std::string folder(jobs::JobId job) const;
  std::string request(jobs::JobId job) const;
  std::string archive(jobs::JobId job) const;
  std::string run(jobs::JobId job) const;  ///< folder of the run store, the events and failures
  std::string failures(jobs::JobId job) const;

  /// Replaces the request atomically and durably. If the folder is missing, creates it. Throws
  /// base::Error.
  void write_request(jobs::JobId job, const std::string& text, base::FileSystem& files) const;

  /// Highest job id among the job folders. The job may be unknown. 0: there are no folders.
  std::uint64_t highest() const;

  /// Renames the folder. clear_away() will delete it. Returns whether the folder existed.
  bool set_aside(jobs::JobId job) const;
  /// As far as possible, deletes all folders that this daemon or an earlier daemon set aside. Slow
  /// for large folders.
  void clear_away() const;

  /// Total size of the job's files that are readable.
  std::uint64_t bytes(jobs::JobId job) const;

 private:
  std::string state_;
};

/// Free space on the folder's disk. 0: unknown.
std::uint64_t disk_free_bytes(const std::string& folder);

}  // namespace sleight::daemon
