// What each user has: core-seconds that decay, an allowance of core-hours that flows back, cores in
// use, bytes on disk and jobs that are not over.
//
// With c cores in use, what a user has had obeys du/dt = c - u ln2 / half-life; between two changes
// of c it is known in closed form, so nothing is summed step by step.
//
// Thread safety: none.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "service/jobs/job.h"
#include "service/jobs/options.h"

namespace sleight::jobs {

struct Account {
  Usage usage{};
  std::uint32_t cores = 0;           ///< of open attempts
  std::uint32_t cores_stopping = 0;  ///< of these, asked to stop
  std::uint32_t cores_waiting = 0;   ///< of these, in a batch system's queue: not used yet
  std::uint64_t unfinished = 0;      ///< jobs that aren't over
  std::uint64_t disk_bytes = 0;
  std::optional<double> idle_since_s{};  ///< since when it waits with nothing running
  double turn_s = 0;  ///< when a job that had waited longest was last put before its others
};

class Accounts {
 public:
  /// Borrows the options.
  explicit Accounts(const Options& options) : options_(options) {}

  void restore(const Usage& usage);
  Account& of(UserId user);
  const Account* find(UserId user) const;
  const Limits& limits(UserId user) const;

  /// Core-seconds that the user has had, decayed to now.
  double had_core_s(UserId user, double now_s) const;
  /// The same and what its running jobs will have had soon (Options::horizon_s).
  double standing_core_s(UserId user, double now_s) const;
  bool is_over_core_hours(UserId user, double now_s, bool is_held) const;
  bool is_over_bytes(UserId user, bool is_held) const;

  /// Brings the user's usage to now, before its cores change.
  void advance(UserId user, double now_s);

  const std::map<UserId, Account>& all() const { return accounts_; }

 private:
  Usage at(const Account& account, double now_s) const;

  const Options& options_;
  std::map<UserId, Account> accounts_;
};

}  // namespace sleight::jobs
