// Reads a run's events from its folder: from the event log (common/events/event_log.h), and from
// the store if numbered events are missing in the log.
//
// Invariants
//   1. Numbered events are returned in order from the requested number on, without gaps, and each
//     only once.
//   2. Numbered events are in the store, so they never change.
//   3. Each answer ends with unnumbered events: the newest of each kind, if the reader hasn't
//     received it.
//
// Reading never delays the writer. The store is opened only if events are missing in the log. On a
// network disk, only the writer's process can open the store.
//
// Thread safety: each reader belongs to one thread; a run may have any number of readers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/events/run_event.h"

namespace sleight::store {

/// Follows a run's events from a number on. For watchers that poll.
///
///   ToldEvents told(folder, last_number_seen + 1);
///   told.next(100) -> {5, 6, 7, progress}    told.next(100) -> {}    told.next(100) -> {8} ...
///
/// The folder and its run may be created after this object, and the log may be deleted at any time.
class ToldEvents {
 public:
  /// REQUIRES: number >= 1.
  explicit ToldEvents(std::string folder, std::uint64_t number = 1);

  /// Returns the log's new events. At most `numbered_max` of these events are numbered. If the log
  /// lacks numbered events, they are read from the store. If there are no new events, this function
  /// only opens a file and reads its size. If the function needs the store but can't read it,
  /// throws base::Error. REQUIRES: numbered_max >= 1.
  std::vector<events::RunEvent> next(std::size_t numbered_max);

  /// Like next(), but also returns events that are only in the store because the log couldn't be
  /// written. Call this after a run's program has ended, and from time to time.
  std::vector<events::RunEvent> rest(std::size_t numbered_max);

  std::uint64_t number() const { return number_; }

 private:
  struct LogPlace {
    std::uint64_t device = 0;
    std::uint64_t inode = 0;  ///< 0: no log was read
    std::uint64_t offset = 0;
  };
  class LogFile;
  struct Answer;

  void read_log(Answer& answer);
  bool take(const LogFile& file, Answer& answer);
  bool take_lines(const std::string& text, Answer& answer);
  void fill_from_store(std::uint64_t end, Answer& answer);

  std::string folder_;
  std::uint64_t number_;
  LogPlace place_;
};

/// Returns the events from `number` on, from the log and the store. At most `numbered_max` of the
/// events are numbered.
std::vector<events::RunEvent> events_told(const std::string& folder, std::uint64_t number,
                                          std::size_t numbered_max);

}  // namespace sleight::store
