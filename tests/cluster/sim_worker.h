// A simulated worker process. Assignments wait in a queue. Each thread runs one block at a time,
// and sends the results when the block's cost has elapsed.
//
// A worker may die: its queue, states and running blocks are lost, and a later start is a new
// incarnation. A worker may also stall: it does nothing until the stall ends, and then handles
// everything that it received meanwhile. A worker answers pings. A worker sends a hello at its
// start. While a worker has no work or has received nothing, it repeats the hello periodically, so
// that a new coordinator notices the worker.
//
// Not thread-safe. The worker's owner, the cluster, outlives all events.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <set>
#include <utility>

#include "service/core/messages.h"
#include "tests/cluster/event_queue.h"
#include "tests/cluster/hash_worker.h"
#include "tests/cluster/scenario.h"
#include "tests/cluster/wrong_parts.h"
#include "worker/sampling/block_runner.h"

namespace sleight::cluster {

/// Counts working threads over time. Not thread-safe.
class Meter {
 public:
  void change(double now_s, int threads) {
    thread_s_ += (now_s - since_s_) * busy_;
    since_s_ = now_s;
    busy_ += threads;
  }
  /// Returns the threads' total working time until now.
  double thread_s(double now_s) const { return thread_s_ + (now_s - since_s_) * busy_; }

 private:
  double thread_s_ = 0;
  double since_s_ = 0;
  int busy_ = 0;
};

class SimWorker {
 public:
  using Send = std::function<void(core::Input)>;

  /// Borrows all arguments. The clock measures costs. No other object may use it.
  SimWorker(const Scenario& scenario, std::uint32_t id, EventQueue& events,
            base::ManualClock& clock, Meter& meter, Send send);

  /// Starts a new incarnation, unless the worker is alive.
  void start();
  void die();
  void stall(double until_s) { stalled_until_s_ = std::max(stalled_until_s_, until_s); }
  void receive(const schema::Assignment& assignment);
  void receive(const schema::Ping& ping);

  bool is_alive() const { return process_ != nullptr; }
  core::WorkerId id() const { return id_; }

 private:
  /// State that a death destroys.
  struct Process {
    Process(const Scenario& scenario, std::uint32_t id, base::ManualClock& clock);
    HashWorker units;
    sampling::BlockRunner blocks;
    WrongBlocks wrong_blocks;
    std::deque<schema::Assignment> queue;
    std::multiset<std::pair<std::uint64_t, std::uint64_t>> running;  ///< (epoch, assignment)
  };
  void when_awake(const EventQueue::Action& action);
  void say_hello();
  void greet_now_and_then();
  void work();

  const Scenario& scenario_;
  core::WorkerId id_;
  std::uint32_t threads_;
  EventQueue& events_;
  base::ManualClock& clock_;
  Meter& meter_;
  Send send_;
  std::uint64_t incarnation_ = 0;
  std::unique_ptr<Process> process_;
  double stalled_until_s_ = 0;
  double heard_s_ = 0;
};

}  // namespace sleight::cluster
