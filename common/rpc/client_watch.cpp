// Implements watching over a Link (link.h), without sockets.
#include <algorithm>

#include "common/base/check.h"
#include "common/rpc/link.h"

namespace sleight::rpc {

Patience::Patience(Link& link, const ClientOptions& options)
    : link_(link), options_(options), wait_s_(options.first_wait_s) {}

void Patience::again(const std::string& words) {
  if (!is_away_) away_since_s_ = link_.now_s();
  is_away_ = true;
  was_there_ = true;  // otherwise the caller would have given up
  if (link_.now_s() - away_since_s_ > options_.away_s_max)
    throw NoServer(words + "; the server did not return in time");
  link_.pause(wait_s_);
  wait_s_ = std::min(2 * wait_s_, options_.wait_s_max);
}

void Patience::reset() {
  is_away_ = false;
  was_there_ = true;
  wait_s_ = options_.first_wait_s;
}

namespace {

class Watched {
 public:
  Watched(std::vector<WatchPoint> points, WatchSink& sink)
      : open_(std::move(points)), sink_(sink) {}

  const std::vector<WatchPoint>& open() const { return open_; }

  /// Returns false if the sink stops the watch.
  bool take(const ArrivedBatch& batch) {
    const auto point = std::find_if(open_.begin(), open_.end(),
                                    [&](const WatchPoint& p) { return p.job == batch.job; });
    if (point == open_.end()) return true;
    if (batch.refusal) return drop(point, *batch.refusal);
    for (const StateChange& change : batch.changes) {
      if (change.number <= point->change) continue;
      point->change = change.number;
      if (!sink_.changed(point->job, change)) return false;
    }
    for (const auto& [number, line] : batch.events) {
      if (number != 0 && number <= point->event) continue;
      if (number > point->event + 1) return drop(point, gap());
      if (number != 0) point->event = number;
      const WatchedEvent event = {
          .job = point->job, .number = number, .line = line, .event = events::run_event_of(line)};
      if (!sink_.happened(event)) return false;
    }
    point->mark = batch.mark;
    if (!batch.settled) return true;
    const JobId job = point->job;
    open_.erase(point);
    return sink_.settled(job);
  }

 private:
  using Place = std::vector<WatchPoint>::iterator;

  bool drop(Place point, const Refusal& refusal) {
    const JobId job = point->job;
    open_.erase(point);
    return sink_.refused(job, refusal);
  }

  static Refusal gap() {
    return {.kind = RefusalKind::bug,
            .sentence = "The server left out an event of the job.",
            .what_to_do = "`sleight status` shows the job's state."};
  }

  std::vector<WatchPoint> open_;
  WatchSink& sink_;
};

bool is_passing(const Refusal& refusal) {
  return refusal.kind == RefusalKind::busy;
}

}  // namespace

Waited watch_over(Link& link, const ClientOptions& options, const std::vector<WatchPoint>& points,
                  WatchSink& sink) {
  Watched watched(points, sink);
  Patience patience(link, options);
  // Report only the first of several failed attempts to the sink.
  const auto lost = [&](const std::string& words) {
    if (!patience.is_away() && !sink.lost(words)) return false;
    patience.again(words);
    return true;
  };
  try {
    while (!watched.open().empty()) {
      try {
        const std::vector<ArrivedBatch> batches = link.watch(watched.open());
        const bool was_away = patience.is_away();
        patience.reset();
        if (was_away && !sink.found_again()) return Waited::stopped;
        for (const ArrivedBatch& batch : batches) {
          if (!watched.take(batch)) return Waited::stopped;
        }
      } catch (const Lost& error) {
        if (!lost(error.what())) return Waited::stopped;
      } catch (const NoServer& error) {
        if (!patience.was_there()) throw;
        if (!lost(error.what())) return Waited::stopped;
      } catch (const RefusedError& error) {
        if (!is_passing(error.refusal())) throw;
        if (!lost(error.what())) return Waited::stopped;
      }
    }
  } catch (const Interrupted&) {
    return Waited::interrupted;
  }
  return Waited::settled;
}

}  // namespace sleight::rpc
