// What a run has told, read from its folder: its log of events (common/events/event_log.h), and
// from its store the numbered events that the log has lost.
//
// Invariants
//   1. Numbered events come in order, from the number asked for on, without a gap, each once.
//   2. An event with a number is in the store: it stays what it is, whatever becomes of the run.
//   3. Of events without a number each answer has the newest one of each kind that is new to the
//      reader, behind the numbered ones.
//
// Reads beside the writer, which it never holds up. Only where something is missing from the log is
// the store opened, which on a network disk the writer's process alone can do.
//
// Thread safety: one reader in one thread; any number of readers of a run.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/events/run_event.h"

namespace sleight::store {

/// Follows a run from a number on: for watchers, which ask again and again.
///
///   ToldEvents told(folder, last_number_seen + 1);
///   told.next(100) -> {5, 6, 7, progress}    told.next(100) -> {}    told.next(100) -> {8} ...
///
/// The folder and its run may come into being later, and the log may be deleted meanwhile.
class ToldEvents {
 public:
  /// REQUIRES: number at least 1.
  explicit ToldEvents(std::string folder, std::uint64_t number = 1);

  /// What is new in the log, at most so many numbered events; the store is asked for those that the
  /// log has lost. Where nothing is new it costs an open file and a look at its size. Throws
  /// base::Error where the store is needed and can't be read. REQUIRES: numbered_max at least 1.
  std::vector<events::RunEvent> next(std::size_t numbered_max);

  /// Likewise, and then what the store alone has: where the log could not be written. For when a
  /// program has ended, and now and then.
  std::vector<events::RunEvent> rest(std::size_t numbered_max);

  /// Of the numbered event that comes next.
  std::uint64_t number() const { return number_; }

 private:
  struct LogPlace {
    std::uint64_t device = 0;
    std::uint64_t inode = 0;  ///< 0: no log has been read
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

/// Everything from a number on as it stands, log and store: at most so many numbered events.
std::vector<events::RunEvent> events_told(const std::string& folder, std::uint64_t number,
                                          std::size_t numbered_max);

}  // namespace sleight::store
