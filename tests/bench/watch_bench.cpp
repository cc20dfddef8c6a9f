// Latency with which a daemon sends a run's events to 100 watchers.
//
// Usage: `sleight-watch-bench SOCKET JOB EVENTS_LOG`.
//
// Watchers are threads. Each watcher watches a running job through its own connection. An event's
// latency starts when its line can first be read in the run's log (checked every 0.5 ms). The
// latency ends when the watcher's sink receives the event. The program ends when the job ends. The
// daemon and the job must be running (service_figures.py).
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "common/base/check.h"
#include "common/base/clock.h"
#include "common/events/run_event.h"
#include "common/rpc/client.h"

namespace sleight::rpc {
namespace {

constexpr int k_watchers = 100;

/// Times by event number, in seconds of a common clock.
using Moments = std::map<std::uint64_t, double>;

class Arrivals final : public WatchSink {
 public:
  explicit Arrivals(Moments& came_s) : came_s_(came_s) {}
  bool changed(JobId, const StateChange&) override { return true; }
  bool happened(const WatchedEvent& event) override {
    if (event.number == 0) return true;
    CHECK_EQ(event.number, ++last_);  // no event lost or repeated
    came_s_[event.number] = clock_.now_s();
    return true;
  }
  bool refused(JobId, const Refusal& refusal) override {
    CHECK_EQ(refusal.sentence, "");
    return false;
  }

 private:
  Moments& came_s_;
  base::SteadyClock clock_;
  std::uint64_t last_ = 0;
};

/// Returns when each new line of the log could first be read.
Moments follow(const std::string& log, const std::atomic<bool>& is_over) {
  const base::SteadyClock clock;
  std::ifstream file(log);
  Moments told_s;
  bool is_new = false;
  std::string line;
  std::string piece;
  while (!is_over) {
    while (std::getline(file, piece)) {
      line += piece;
      if (file.eof()) break;  // the rest of the line comes later
      const auto event = events::run_event_of(line);
      if (is_new && event && event->number > 0) told_s[event->number] = clock.now_s();
      line.clear();
    }
    file.clear();
    is_new = true;
    std::this_thread::sleep_for(std::chrono::microseconds(500));
  }
  return told_s;
}

int run(const std::string& socket, JobId job, const std::string& log) {
  std::vector<Moments> came_s(k_watchers);
  std::vector<std::thread> watchers;
  for (Moments& own : came_s) {
    watchers.emplace_back([&] {
      Arrivals sink(own);
      CHECK(Client(socket).watch({job}, 1, sink) == Waited::settled);
    });
  }
  while (Client(socket).info().watchers < k_watchers)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  std::atomic<bool> is_over = false;
  Moments told_s;
  std::thread follower([&] { told_s = follow(log, is_over); });
  for (std::thread& watcher : watchers)
    watcher.join();
  is_over = true;
  follower.join();
  std::vector<double> all_s;
  for (const Moments& own : came_s) {
    for (const auto& [number, at_s] : told_s)
      all_s.push_back(own.at(number) - at_s);
  }
  if (all_s.empty()) {
    fmt::print(stderr, "the job told no event meanwhile\n");
    return EXIT_FAILURE;
  }
  std::sort(all_s.begin(), all_s.end());
  const auto at = [&](double share) {
    return 1e3 * all_s[static_cast<std::size_t>(share * static_cast<double>(all_s.size() - 1))];
  };
  const double seconds = told_s.rbegin()->second - told_s.begin()->second;
  fmt::print(
      "{} events at {} watchers, {:.0f} a second: median {:.1f} ms, p99 {:.1f} ms, longest "
      "{:.1f} ms\n",
      told_s.size(), k_watchers, static_cast<double>(told_s.size()) / seconds, at(0.5), at(0.99),
      at(1));
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace sleight::rpc

int main(int argc, char** argv) {
  if (argc != 4) {
    fmt::print(stderr, "usage: sleight-watch-bench SOCKET JOB EVENTS_LOG\n");
    return 2;
  }
  return sleight::rpc::run(argv[1], sleight::rpc::JobId{std::strtoull(argv[2], nullptr, 10)},
                           argv[3]);
}
