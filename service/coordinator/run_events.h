// Reports a run's events. A listener in this process receives the events; other processes read the
// log (common/events/event_log.h) and the store in the run's folder.
//
// Data flow:
//   drive ──results, plan──▶ EventSequence ──▶ RunStore: numbered, committed after the results
//     │                                            │ committed
//     │ progress, phases                           ▼
//     └───────────────────────────────────▶ a thread ──▶ events.log
//
// Invariants
//   1. Before a numbered event is reported, the event and its results are committed.
//   2. The driving thread never waits for the log. If the disk is too slow, the log omits lines.
//      Readers restore the numbered lines from the store (store/told_events.h).
//   3. The listener is called only in the thread that calls this class.
//   4. The log's thread starts with the first event, after the listener has received it.
//
// Thread safety: any thread may call archive_written(); one thread calls the other functions.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "common/base/clock.h"
#include "common/events/run_event.h"
#include "common/plan/plan.h"
#include "common/store/run_store.h"
#include "service/coordinator/event_sequence.h"

namespace sleight::coordinator {

/// Interval at which progress is logged. The listener receives all progress.
inline constexpr double k_progress_logged_every_s = 1;
/// Maximum lines that aren't yet written to the log.
inline constexpr std::size_t k_lines_waiting_max = 10'000;

class RunEvents {
 public:
  using Hear = std::function<void(const events::RunEvent&)>;

  /// Borrows store and clock. `hear` may be empty. REQUIRES: nothing was put into the store.
  RunEvents(std::string folder, store::RunStore& store, const base::Clock& clock, Hear hear,
            EventSequence::FileOf file_of = {});
  /// Calls stop().
  ~RunEvents();
  RunEvents(const RunEvents&) = delete;
  RunEvents& operator=(const RunEvents&) = delete;

  void say(const std::string& phase);
  void show(const events::Progress& progress);
  void archive_written(events::ArchiveWritten archive);

  /// Like EventSequence's functions. Call consumed() with results in the order of the store. Then
  /// call advance() with the plan that has consumed these results.
  void consumed(const plan::ReplicaKey& replica, base::ScanIndex first_scan,
                std::span<const plan::ScanRecord> records);
  void advance(const plan::Plan& plan);

  /// Reports the session's end. `number`: this event's number, as the closed store returned it.
  void ended(std::uint64_t number, const events::RunEnd& end);

  /// Waits until the log is complete. No event may follow.
  void stop();

 private:
  void tell(events::RunEvent event);
  void committed(std::span<const events::RunEvent> events);
  void log(events::RunEvent event);
  void hear_committed();
  void work();

  std::string folder_;
  store::RunStore& store_;
  const base::Clock& clock_;
  Hear hear_;
  EventSequence sequence_;
  std::optional<double> progress_logged_s_;
  std::optional<events::RunEvent> progress_left_out_;  ///< newest progress missing in the log

  std::mutex mutex_;  ///< guards all members below
  std::condition_variable changed_;
  std::deque<events::RunEvent>
      waiting_;  ///< for the log; only the newest unnumbered event of each kind
  std::vector<events::RunEvent> to_hear_;  ///< committed events for the listener
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace sleight::coordinator
