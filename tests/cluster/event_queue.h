// Simulated time: events are ordered by (time, number), where the number is the order of
// scheduling. So simultaneous events have one order, and a seed has one history. Not thread-safe.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

namespace sleight::cluster {

class EventQueue {
 public:
  using Action = std::function<void()>;

  double now_s() const { return now_s_; }

  /// REQUIRES: `time_s` is not in the past.
  void at(double time_s, Action action) {
    events_.push_back({.time_s = time_s, .number = next_number_++, .action = std::move(action)});
    std::ranges::push_heap(events_, later);
  }
  void after(double delay_s, Action action) { at(now_s_ + delay_s, std::move(action)); }

  /// Advances to the next event. False: there is none.
  bool run_next() {
    if (events_.empty()) return false;
    std::ranges::pop_heap(events_, later);
    const Event event = std::move(events_.back());
    events_.pop_back();
    now_s_ = event.time_s;
    event.action();
    return true;
  }

 private:
  struct Event {
    double time_s = 0;
    std::uint64_t number = 0;
    Action action;
  };
  static bool later(const Event& a, const Event& b) {
    return std::pair(a.time_s, a.number) > std::pair(b.time_s, b.number);
  }

  double now_s_ = 0;
  std::uint64_t next_number_ = 0;
  std::vector<Event> events_;  ///< a heap, the next event first
};

}  // namespace sleight::cluster
