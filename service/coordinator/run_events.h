// What happens in a run, told to whoever watches: to a listener in this process, and in the run's
// folder to all others, by its log (common/events/event_log.h) and its store.
//
//   drive ──results, plan──▶ EventSequence ──▶ RunStore: numbered, committed behind the results
//     │                                            │ committed
//     │ progress, phases                           ▼
//     └───────────────────────────────────▶ a thread ──▶ events.log
//
// Invariants
//   1. A numbered event is told when it and the results from which it follows are committed.
//   2. The drive's thread never waits for the log; lines that a slow disk does not take in time are
//      left out, and numbered ones made again from the store by readers (store/told_events.h).
//   3. The listener is called in the thread that calls this, never in another.
//   4. The log's thread starts with the first event, after the listener has heard it.
//
// Thread safety: archive_written may be called from any thread, the rest from one.
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

/// Progress goes into the log so often; the listener gets all.
inline constexpr double k_progress_logged_every_s = 1;
/// Lines that may wait for the log.
inline constexpr std::size_t k_lines_waiting_max = 10'000;

class RunEvents {
 public:
  using Hear = std::function<void(const events::RunEvent&)>;

  /// Borrows store and clock. `hear` may be empty. REQUIRES: nothing was put into the store yet.
  RunEvents(std::string folder, store::RunStore& store, const base::Clock& clock, Hear hear,
            EventSequence::FileOf file_of = {});
  /// As stop().
  ~RunEvents();
  RunEvents(const RunEvents&) = delete;
  RunEvents& operator=(const RunEvents&) = delete;

  void say(const std::string& phase);
  void show(const events::Progress& progress);
  void archive_written(events::ArchiveWritten archive);

  /// As EventSequence's: results, in the order in which they are put into the store; then how far
  /// the plan is with what was put.
  void consumed(const plan::ReplicaKey& replica, base::ScanIndex first_scan,
                std::span<const plan::ScanRecord> records);
  void advance(const plan::Plan& plan);

  /// The session is over, and the store is closed with `end` as this event's number.
  void ended(std::uint64_t number, const events::RunEnd& end);

  /// Waits until the log has what it is to have. Nothing may be told afterwards.
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
  std::optional<events::RunEvent> progress_left_out_;  ///< of the log, since

  std::mutex mutex_;  ///< of all below
  std::condition_variable changed_;
  std::deque<events::RunEvent> waiting_;   ///< for the log; without numbers one of each kind
  std::vector<events::RunEvent> to_hear_;  ///< committed
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace sleight::coordinator
