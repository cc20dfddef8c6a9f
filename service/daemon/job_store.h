// The job store: all that a daemon must find again after kill -9 or loss of power, in a SQLite
// database `jobs.sqlite` in its state folder.
//
//   job      a row a job, as it is now
//   change   a row a change of a job, numbered from 1 without a gap
//   request  of each revision of a job's request its normalised text, and what people are told of
//   it usage    what each user has had state    format, service time, next id
//
// Invariants
//   1. A save is one transaction: when `save` has returned, all of it survives; else none of it is
//      there.
//   2. Every row carries a checksum, over its key too: what a disk or a person changed is refused
//      when it is read, and nothing of the store is touched then. So is a store of another format.
//   3. Requests of a job that is erased go with it.
//
// Thread safety: one thread at a time.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/store/database.h"
#include "common/store/run_lock.h"
#include "common/store/shared_database.h"
#include "service/jobs/job.h"
#include "service/jobs/messages.h"

namespace sleight::daemon {

/// Of the tables; a store of another format is refused.
inline constexpr std::int64_t k_job_store_format = 1;

/// A revision of a job's request. What it asks for is kept beside the text, so that a list of jobs
/// reads no requests.
struct StoredRequest {
  jobs::JobId job{};
  std::uint64_t revision = 1;
  std::string text{};                            ///< normalised
  std::string world{};                           ///< its name
  bool strict = false;                           ///< a failed simulation ends the run
  std::uint64_t found_wanted = 0;                ///< by a search; 0: none are asked for
  std::uint64_t in_proportion_wanted = 0;        ///< independent solutions; likewise
  std::string token_id{};                        ///< that it was submitted by; empty: none
  std::map<std::string, std::string> options{};  ///< for the system that runs it
  bool operator==(const StoredRequest&) const = default;
};

/// What becomes durable as one.
/// REQUIRES: a job's request comes with its first revision, and with each new one.
struct Save {
  jobs::Save jobs{};
  std::vector<StoredRequest> requests{};
};

struct StoredJobs {
  std::vector<jobs::Job> jobs{};
  std::vector<jobs::Usage> usages{};
  std::vector<StoredRequest> requests{};  ///< the newest of each job, without its text
  std::map<jobs::JobId, std::uint64_t> change_counts{};
  double clock_s = 0;
  std::uint64_t next_id = 1;
};

class JobStore {
 public:
  /// Opens or makes it. Throws base::Error: conflict where it is of another format, environment
  /// where it is damaged or the disk fails. A save counts only while `lock`, if there is one, is
  /// held: a lease of a network disk may end.
  explicit JobStore(const std::string& path, const store::RunLock* lock = nullptr);

  /// A connection to read by, beside the writing; on a network disk there is one for all.
  std::shared_ptr<store::SharedDatabase> to_read() const;

  /// Everything, for a daemon that begins. Throws base::Error where a row was changed.
  StoredJobs load();

  /// Durable when it returns; throws base::Error where the disk fails, and then nothing is saved,
  /// and with ExitCode::conflict where the lock is lost: another daemon may have the folder.
  void save(std::span<const Save* const> saves);

 private:
  void create_or_check();
  void put(const Save& save);
  void put_requests(const Save& save);
  void erase(jobs::JobId job);
  std::string state_value(std::string_view key);
  void set_state(std::string_view key, std::string_view value);

  std::shared_ptr<store::SharedDatabase> shared_;
  store::Database& database_;  ///< of `shared_`, in a turn
  const store::RunLock* lock_;
};

/// Reads beside the daemon's writing. Functions throw base::Error where a row was changed.
class JobReader {
 public:
  explicit JobReader(std::shared_ptr<store::SharedDatabase> shared) : shared_(std::move(shared)) {}

  struct NumberedChange {
    std::uint64_t number = 0;
    jobs::Change change;
  };
  /// From a number on, at most so many.
  std::vector<NumberedChange> changes(jobs::JobId job, std::uint64_t from, std::size_t count_max);
  std::uint64_t change_count(jobs::JobId job);
  /// None: not there, or erased.
  std::optional<StoredRequest> request(jobs::JobId job, std::uint64_t revision);

 private:
  std::shared_ptr<store::SharedDatabase> shared_;
};

}  // namespace sleight::daemon
