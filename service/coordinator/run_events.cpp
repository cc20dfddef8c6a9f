#include "service/coordinator/run_events.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "common/events/event_log.h"
#include "common/logging/log.h"

namespace sleight::coordinator {

RunEvents::RunEvents(std::string folder, store::RunStore& store, const base::Clock& clock,
                     Hear hear, EventSequence::FileOf file_of)
    : folder_(std::move(folder)),
      store_(store),
      clock_(clock),
      hear_(std::move(hear)),
      sequence_(store.told(), std::move(file_of)) {
  store_.on_told([this](std::span<const events::RunEvent> events) { committed(events); });
}

RunEvents::~RunEvents() {
  store_.on_told({});
  stop();
}

void RunEvents::say(const std::string& phase) {
  tell({.what = events::Phase{.words = phase}});
}

void RunEvents::show(const events::Progress& progress) {
  hear_committed();
  const events::RunEvent event{.what = progress};
  if (hear_) hear_(event);
  const double now_s = clock_.now_s();
  if (progress_logged_s_ && now_s - *progress_logged_s_ < k_progress_logged_every_s) {
    progress_left_out_ = event;
    return;
  }
  progress_logged_s_ = now_s;
  progress_left_out_.reset();
  log(event);
}

void RunEvents::archive_written(events::ArchiveWritten archive) {
  events::RunEvent event{.what = std::move(archive)};
  if (hear_) {
    const std::scoped_lock lock(mutex_);
    to_hear_.push_back(event);
  }
  log(std::move(event));
}

void RunEvents::consumed(const plan::ReplicaKey& replica, base::ScanIndex first_scan,
                         std::span<const plan::ScanRecord> records) {
  sequence_.consumed(replica, first_scan, records);
}

void RunEvents::advance(const plan::Plan& plan) {
  std::vector<events::RunEvent> events = sequence_.advance(plan);
  if (!events.empty())
    store_.put(store::PutEvents{.events = std::move(events), .reached = sequence_.frontier()});
  hear_committed();
}

void RunEvents::ended(std::uint64_t number, const events::RunEnd& end) {
  hear_committed();
  if (progress_left_out_) log(*std::exchange(progress_left_out_, std::nullopt));
  tell({.number = number, .what = end});
}

/// Calls the listener before the log's thread starts. Until the listener has returned, the process
/// may rely on having only one thread.
void RunEvents::tell(events::RunEvent event) {
  if (hear_) hear_(event);
  log(std::move(event));
}

/// Called in the store's thread.
void RunEvents::committed(std::span<const events::RunEvent> events) {
  if (hear_) {
    const std::scoped_lock lock(mutex_);
    to_hear_.insert(to_hear_.end(), events.begin(), events.end());
  }
  for (const events::RunEvent& event : events)
    log(event);
}

void RunEvents::hear_committed() {
  if (!hear_) return;
  std::vector<events::RunEvent> events;
  {
    const std::scoped_lock lock(mutex_);
    events = std::exchange(to_hear_, {});
  }
  for (const events::RunEvent& event : events)
    hear_(event);
}

void RunEvents::log(events::RunEvent event) {
  {
    const std::scoped_lock lock(mutex_);
    if (stop_) return;
    if (event.number == 0) {
      std::erase_if(waiting_, [&](const events::RunEvent& other) {
        return other.number == 0 && other.what.index() == event.what.index();
      });
    }
    if (waiting_.size() < k_lines_waiting_max) waiting_.push_back(std::move(event));
    try {
      if (!thread_.joinable()) thread_ = std::thread([this] { work(); });
    } catch (const std::system_error& failure) {
      logging::warn(fmt::format("{}: can't write the event log: {}", folder_, failure.what()));
      stop_ = true;
    }
  }
  changed_.notify_all();
}

void RunEvents::stop() {
  {
    const std::scoped_lock lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void RunEvents::work() {
  events::EventLog log(folder_);
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return stop_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    const std::deque<events::RunEvent> taken = std::exchange(waiting_, {});
    lock.unlock();
    for (const events::RunEvent& event : taken)
      log.append(event);
    lock.lock();
  }
}

}  // namespace sleight::coordinator
