// What a job's run has told, held for those who ask often: its newest progress for lists, and its
// newest events for watchers.
//
// The run writes its events into its folder (common/store/told_events.h); a feed follows them. A
// watcher that lacks more than is held gets it from the folder itself, so what a feed holds is
// bounded and nothing rests on it.
//
// Marks number what is unnumbered, so that a watcher gets the newest of each kind once. They begin
// at the wall clock's microseconds: a feed that is made later, by another daemon too, mostly knows
// those of an earlier one as past. A mark that it doesn't know gets everything that is newest.
//
// Thread safety: one thread.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/events/run_event.h"
#include "common/store/told_events.h"

namespace sleight::daemon {

class JobFeed {
 public:
  /// Numbered events that are held.
  static constexpr std::size_t k_held_max = 1024;

  JobFeed(std::string run_folder, std::uint64_t first_mark);

  /// Reads what is new; whether there was something. `thoroughly`: the store is asked as well, for
  /// what the log may never have had. A folder that can't be read has nothing new.
  bool read(bool thoroughly);

  /// Numbered events from `after` + 1 on, at most `count_max`, and of the others the newest of each
  /// kind that `mark` doesn't cover.
  struct News {
    std::vector<events::RunEvent> events{};
    std::uint64_t mark = 0;
    bool is_all = true;  ///< nothing numbered is left out
  };
  News after(std::uint64_t after, std::uint64_t mark, std::size_t count_max) const;

  const std::optional<events::Progress>& progress() const { return progress_; }
  /// Why the last reading came to nothing; empty: it did not.
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
