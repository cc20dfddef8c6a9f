// Each user's account: decaying core-seconds, core-hours that refill evenly, cores in use, bytes on
// disk, unfinished jobs.
//
// With c cores in use, a user's core-seconds u obey du/dt = c - u ln2 / half-life. Between two
// changes of c the solution has a closed form, so no numerical integration is needed.
//
// Thread safety: none.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "service/jobs/job.h"
#include "service/jobs/options.h"

namespace sleight::jobs {

struct Account {
  Usage usage{};
  std::uint32_t cores = 0;           ///< of open attempts
  std::uint32_t cores_stopping = 0;  ///< of `cores`: attempts asked to stop
  std::uint32_t cores_waiting =
      0;                         ///< of `cores`: still in a batch system's queue, so not used yet
  std::uint64_t unfinished = 0;  ///< jobs that aren't over
  std::uint64_t disk_bytes = 0;
  std::optional<double> idle_since_s{};  ///< since when the user waits with nothing running
  double turn_s = 0;                     ///< when the user's longest-waiting job last went first
};

class Accounts {
 public:
  /// Borrows the options.
  explicit Accounts(const Options& options) : options_(options) {}

  void restore(const Usage& usage);
  Account& of(UserId user);
  const Account* find(UserId user) const;
  const Limits& limits(UserId user) const;

  /// Returns the core-seconds that the user's jobs have used up to `now_s`, decayed.
  double had_core_s(UserId user, double now_s) const;
  /// Returns had_core_s() plus the core-seconds that the user's running jobs will use within
  /// Options::horizon_s.
  double standing_core_s(UserId user, double now_s) const;
  bool is_over_core_hours(UserId user, double now_s, bool is_held) const;
  bool is_over_bytes(UserId user, bool is_held) const;

  /// Updates the user's usage to `now_s`. Call this before the number of the user's cores changes.
  void advance(UserId user, double now_s);

  const std::map<UserId, Account>& all() const { return accounts_; }

 private:
  Usage at(const Account& account, double now_s) const;

  const Options& options_;
  std::map<UserId, Account> accounts_;
};

}  // namespace sleight::jobs
