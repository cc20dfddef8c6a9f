// Paths in a job's folder, and the daemon's operations on them; the keeper (service/keeper) writes
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
  /// Folder of files that clients fetch, emptied when a daemon starts.
  std::string fetched() const { return state_ + "/fetched"; }
  std::string folder(jobs::JobId job) const;
  std::string request(jobs::JobId job) const;
  std::string archive(jobs::JobId job) const;
  std::string run(jobs::JobId job) const;  ///< folder of the run store, the events and failures
  std::string failures(jobs::JobId job) const;

  /// Creates the folder if necessary; replaces the request atomically and durably. Throws
  /// base::Error.
  void write_request(jobs::JobId job, const std::string& text, base::FileSystem& files) const;

  /// Highest job id of any job folder, whether or not the job is known. 0: there are no folders.
  std::uint64_t highest() const;

  /// Renames the folder, so that clear_away() deletes it. Returns whether the folder existed.
  bool set_aside(jobs::JobId job) const;
  /// Deletes all folders that were set aside by this or an earlier daemon, as far as possible. Slow
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
