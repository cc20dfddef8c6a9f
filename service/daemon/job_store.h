// The job store: a SQLite database `jobs.sqlite` in the state folder, which survives power loss.
//
//   `job`      has one row per job: its current record.
//   `change`   has one row per change of a job. Each job's changes are numbered from 1 without
//              gaps.
//   `request`  has one row per revision of a request. A row has the normalised text and what
//              clients see.
//   `usage`    has one row per user: the use so far.
//   `state`    has format, service time and next id.
//
// Invariants
//   1. A save is one transaction. A save is durable when `save` returns, and otherwise has no
//      effect.
//   2. Every row has a checksum that also covers its key. If a checksum is wrong, reading throws
//      and doesn't change the store. A store of another format is refused too.
//   3. Erasing a job erases its requests.
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

/// Format of the tables. If a store has another format, it is refused.
inline constexpr std::int64_t k_job_store_format = 1;

/// A revision of a job's request. Listing jobs doesn't read the text.
struct StoredRequest {
  jobs::JobId job{};
  std::uint64_t revision = 1;
  std::string text{};                            ///< normalised
  std::string world{};                           ///< its name
  bool strict = false;                           ///< a failed simulation ends the run
  std::uint64_t found_wanted = 0;                ///< by a search; 0: no goal
  std::uint64_t in_proportion_wanted = 0;        ///< independent solutions; 0: no goal
  std::string token_id{};                        ///< token of the submit; empty: none
  std::map<std::string, std::string> options{};  ///< for the batch system
  bool operator==(const StoredRequest&) const = default;
};

/// One transaction. REQUIRES: `requests` contains the request of each new revision, including a
/// job's first revision.
struct Save {
  jobs::Save jobs{};
  std::vector<StoredRequest> requests{};
};

struct StoredJobs {
  std::vector<jobs::Job> jobs{};
  std::vector<jobs::Usage> usages{};
  std::vector<StoredRequest> requests{};  ///< newest of each job, without its text
  std::map<jobs::JobId, std::uint64_t> change_counts{};
  double clock_s = 0;
  std::uint64_t next_id = 1;
};

class JobStore {
 public:
  /// Opens or creates the store. Throws base::Error(conflict) if the store has another format, and
  /// base::Error(environment) if it is damaged or the disk fails. With a `lock`, a save succeeds
  /// only while the lock is held. On a network disk, the lock's lease can expire.
  explicit JobStore(const std::string& path, const store::RunLock* lock = nullptr);

  /// Returns a connection for reading. On a network disk, this is the writer's connection;
  /// otherwise it is a separate connection.
  std::shared_ptr<store::SharedDatabase> to_read() const;

  /// Loads everything, for a starting daemon. Throws base::Error if a row was changed.
  StoredJobs load();

  /// Saves durably, or throws base::Error and saves nothing. ExitCode::conflict means that the lock
  /// is lost, so another daemon may have the folder.
  void save(std::span<const Save* const> saves);

  /// Moves SQLite's write-ahead log into the database file. The file is then complete.
  void empty_log();

 private:
  void create_or_check();
  void put(const Save& save);
  void put_requests(const Save& save);
  void erase(jobs::JobId job);
  std::string state_value(std::string_view key);
  void set_state(std::string_view key, std::string_view value);

  std::shared_ptr<store::SharedDatabase> shared_;
  store::Database& database_;  ///< of `shared_`, used in its turn
  const store::RunLock* lock_;
};

/// Reads beside the daemon's writing. Functions throw base::Error if a row was changed.
class JobReader {
 public:
  explicit JobReader(std::shared_ptr<store::SharedDatabase> shared) : shared_(std::move(shared)) {}

  struct NumberedChange {
    std::uint64_t number = 0;
    jobs::Change change;
  };
  /// Returns at most `count_max` changes, from number `from` on.
  std::vector<NumberedChange> changes(jobs::JobId job, std::uint64_t from, std::size_t count_max);
  std::uint64_t change_count(jobs::JobId job);
  /// None: the revision doesn't exist, or it was erased.
  std::optional<StoredRequest> request(jobs::JobId job, std::uint64_t revision);

 private:
  std::shared_ptr<store::SharedDatabase> shared_;
};

}  // namespace sleight::daemon
