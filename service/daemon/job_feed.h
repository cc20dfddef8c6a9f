// Caches a job's newest run events. Lists of jobs show progress; watchers get all kinds of events.
//
// The run writes its events into its folder (common/store/told_events.h), and the feed follows
// them. If a watcher needs older events than the feed holds, they are read from the folder. So the
// feed's size is bounded, and nothing depends on its contents.
//
// Each unnumbered event gets a mark. So a watcher gets the newest event of each kind only once. A
// feed's first mark is the wall clock in microseconds. So if a feed is created later, even by
// another daemon, its marks are usually higher. For an unknown mark, a feed returns the newest
// event of every kind.
//
// Thread safety: one thread.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/events/run_event.h"
#include "common/store/told_events.h"

namespace sleight::daemon {

class JobFeed {
 public:
  /// Maximum numbered events held.
  static constexpr std::size_t k_held_max = 1024;

  JobFeed(std::string run_folder, std::uint64_t first_mark);

  /// Reads new events and returns whether there were any. `thoroughly` also reads the store,
  /// because the log may lack events. If the folder can't be read, there are no new events.
  bool read(bool thoroughly);

  /// Contains at most `count_max` numbered events, from `after` + 1 on. If a kind's newest
  /// unnumbered event is newer than `mark`, it follows.
  struct News {
    std::vector<events::RunEvent> events{};
    std::uint64_t mark = 0;
    bool is_all = true;  ///< no numbered event is left out
  };
  News after(std::uint64_t after, std::uint64_t mark, std::size_t count_max) const;

  const std::optional<events::Progress>& progress() const { return progress_; }
  /// Why the last reading failed. Empty: it didn't.
  const std::string& trouble() const { return trouble_; }

 private:
  struct Marked {
    std::uint64_t mark = 0;
    events::RunEvent event;
  };
  void take(events::RunEvent event);

  std::string folder_;
  store::ToldEvents told_;
  std::deque<events::RunEvent> held_{};                  ///< numbered, consecutive, the newest last
  std::map<std::string, Marked, std::less<>> newest_{};  ///< by kind
  std::optional<events::Progress> progress_{};
  std::uint64_t last_number_ = 0;  ///< of the newest numbered event; 0: none
  std::string trouble_{};
  std::uint64_t mark_;
};

}  // namespace sleight::daemon
