// A run's events as a file in its folder, for whoever watches: other processes, other nodes, a
// service that was not there when they happened.
//
// Two files, `events.log` and `events.old.log`, each of at most half the bound: when the first is
// full it takes the place of the second. Lines are run_event.h's, appended whole.
//
// Nothing rests on the log: what it has lost is made again from the store. So it is not synced to
// the disk, and a disk that fails ends no run. That is said once; a second later it is tried again.
// A log that somebody deletes is begun anew, likewise.
//
// Thread safety: one writer in one thread; any number of readers anywhere.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/events/run_event.h"

namespace sleight::events {

inline constexpr std::uint64_t k_event_log_bytes_max = 4U << 20U;
/// After so long it is looked whether the log can be written, and is where it was.
inline constexpr double k_event_log_look_every_s = 1;

/// The log in a run's folder, and what was the log before.
std::string event_log_path(const std::string& folder);
std::string old_event_log_path(const std::string& folder);

class EventLog {
 public:
  /// Goes on with the log of an earlier session, whose last line may be torn: it is cut off.
  explicit EventLog(std::string folder, std::uint64_t bytes_max = k_event_log_bytes_max);
  /// Borrows a clock.
  EventLog(std::string folder, std::uint64_t bytes_max, const base::Clock& clock);
  ~EventLog();
  EventLog(const EventLog&) = delete;
  EventLog& operator=(const EventLog&) = delete;

  void append(const RunEvent& event);

 private:
  void open();
  void look_now_and_then();
  void turn_over();
  void give_up(const std::string& reason);

  std::string folder_;
  std::uint64_t bytes_max_;
  base::SteadyClock own_clock_;
  const base::Clock& clock_;
  double looked_s_;
  int descriptor_ = -1;  ///< -1: it can't be written at present
  std::uint64_t bytes_ = 0;
  bool has_complained_ = false;
};

/// What the log has, in order; a line that is being written is left out, and one that is damaged.
/// Nothing where there is no log.
std::vector<RunEvent> read_event_log(const std::string& folder);

}  // namespace sleight::events
