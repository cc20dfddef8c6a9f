// Stores a run's events in files of the run's folder. Watchers in other processes or on other
// machines read them, even later.
//
// There are two files, `events.log` and `events.old.log`, each at most half the size limit. When
// `events.log` is full, it replaces `events.old.log`. Each event is a line as in run_event.h. A
// line is appended by a single write.
//
// Nothing depends on the log, because lost events are restored from the store. So the log is not
// synced, and a failing disk does not end a run: the failure is reported once, and writing is
// retried after a second. At most once per second, the writer checks whether the log was deleted.
// If so, the writer starts a new log.
//
// Thread safety: a log has one writer, used by one thread, and any number of readers.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/events/run_event.h"

namespace sleight::events {

inline constexpr std::uint64_t k_event_log_bytes_max = 4U << 20U;
/// Interval at which the writer checks that the log still exists, and retries after a failure.
inline constexpr double k_event_log_look_every_s = 1;

/// Return the paths of `events.log` and `events.old.log` in a run's folder.
std::string event_log_path(const std::string& folder);
std::string old_event_log_path(const std::string& folder);

class EventLog {
 public:
  /// Continues the log of an earlier session, and removes an incomplete last line.
  explicit EventLog(std::string folder, std::uint64_t bytes_max = k_event_log_bytes_max);
  /// Borrows `clock`.
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
  int descriptor_ = -1;  ///< -1: not writable at present
  std::uint64_t bytes_ = 0;
  bool has_complained_ = false;
};

/// Returns the log's events in order. Omits damaged lines, and a line that is still being written.
/// Empty if there is no log.
std::vector<RunEvent> read_event_log(const std::string& folder);

}  // namespace sleight::events
