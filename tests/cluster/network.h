// The network between coordinator and workers. Messages have independent delays, so they may
// overtake each other. In bad weather some messages are lost, repeated, or late. Not thread-safe.
#pragma once

#include "tests/cluster/dice.h"
#include "tests/cluster/event_queue.h"

namespace sleight::cluster {

struct Latency {
  double least_s = 20e-6;
  double most_s = 200e-6;
};

/// Probabilities per message.
struct Weather {
  double lost = 0;
  double doubled = 0;
  double late = 0;
  double late_s_max = 0;  ///< maximum extra delay of a late message
};

class Network {
 public:
  Network(EventQueue& events, std::uint64_t seed, const Latency& latency)
      : events_(events), dice_(seed, Dice::Part::network), latency_(latency) {}

  void set(const Weather& weather) { weather_ = weather; }

  /// Calls `arrive` when the message arrives: never, once or twice.
  void send(const EventQueue::Action& arrive) {
    if (dice_.chance(weather_.lost)) return;
    const int copies = dice_.chance(weather_.doubled) ? 2 : 1;
    for (int copy = 0; copy < copies; ++copy) {
      double delay_s = dice_.uniform(latency_.least_s, latency_.most_s);
      if (dice_.chance(weather_.late)) delay_s += dice_.uniform(0, weather_.late_s_max);
      events_.after(delay_s, arrive);
    }
  }

 private:
  EventQueue& events_;
  Dice dice_;
  Latency latency_;
  Weather weather_;
};

}  // namespace sleight::cluster
