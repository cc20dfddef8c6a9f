// A job's folder in the daemon's state folder: where its files are, and what the daemon does to
// them. The keeper (service/keeper) has the rest.
//
// Thread safety: functions of the files alone; one thread works on a job's folder at a time.
#pragma once

#include <cstdint>
#include <string>

#include "common/base/file_system.h"
#include "service/jobs/job.h"

namespace sleight::daemon {

class JobFolders {
 public:
  /// `state` is the daemon's folder, an absolute path.
  explicit JobFolders(std::string state) : state_(std::move(state)) {}

  std::string all() const { return state_ + "/jobs"; }
  /// Of files that clients fetch: emptied when a daemon begins.
  std::string fetched() const { return state_ + "/fetched"; }
  std::string folder(jobs::JobId job) const;
  std::string request(jobs::JobId job) const;
  std::string archive(jobs::JobId job) const;
  std::string run(jobs::JobId job) const;  ///< folder of the run store, the events and failures
  std::string failures(jobs::JobId job) const;

  /// Makes the folder if need be and replaces the request in one step, durably. Throws base::Error.
  void write_request(jobs::JobId job, const std::string& text, base::FileSystem& files) const;

  /// The highest number that a folder of a job has, whether or not the job is known; 0: none.
  std::uint64_t highest() const;

  /// Moves the folder out of the way, at once, to be deleted by `clear_away`. False: there is none.
  bool set_aside(jobs::JobId job) const;
  /// Deletes what was set aside, also by earlier daemons; what can't be deleted stays. Takes long
  /// where there is much.
  void clear_away() const;

  /// Of all its files, as far as they can be seen.
  std::uint64_t bytes(jobs::JobId job) const;

 private:
  std::string state_;
};

/// Free on the disk of a folder; 0 where the system doesn't say.
std::uint64_t disk_free_bytes(const std::string& folder);

}  // namespace sleight::daemon
