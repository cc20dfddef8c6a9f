// One session of a simulated coordinator. The session uses the real scheduler and a fresh real plan
// on the simulated clock. The session drives both as service/coordinator/drive.cpp does.
//
// The coordinator handles incoming messages one at a time, in the order of arrival, and takes
// handling_s for each. A session's end or death cancels its later actions. Not thread-safe.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "service/core/scheduler.h"
#include "tests/cluster/event_queue.h"
#include "tests/cluster/scenario.h"
#include "tests/cluster/sim_store.h"
#include "tests/cluster/wrong_parts.h"

namespace sleight::cluster {

class SimCoordinator : public std::enable_shared_from_this<SimCoordinator> {
 public:
  /// Receives messages to workers, and is told when the session ends.
  struct Outside {
    std::function<void(core::WorkerId, schema::Assignment)> assign;
    std::function<void(core::WorkerId, schema::Ping)> ask;
    std::function<void()> left;  ///< with work left
    std::function<void()> finished;
  };

  /// Borrows all arguments. REQUIRES: opening the store returned this epoch.
  SimCoordinator(const Scenario& scenario, std::uint64_t epoch, SimStore& store, EventQueue& events,
                 Outside outside);

  void begin();
  void receive(core::Input input);
  void die() { is_dead_ = true; }

  const plan::Plan& plan() const { return *plan_; }
  const core::Counts& counts() const { return scheduler_.counts(); }

 private:
  void catch_up();
  void carry_out(core::Input input);
  std::vector<core::Effect> step(core::Input input);
  void tick();
  void commit_soon();
  void commit();
  void end_if_over();
  /// Calls the action at `time_s`, unless this session has ended.
  void at(double time_s, std::function<void(SimCoordinator&)> action);

  const Scenario& scenario_;
  SimStore& store_;
  EventQueue& events_;
  Outside outside_;
  std::unique_ptr<plan::Plan> plan_;
  core::Scheduler scheduler_;
  WrongDeliveries wrong_;
  double busy_until_s_ = 0;
  bool commit_waits_ = false;
  bool is_dead_ = false;
};

}  // namespace sleight::cluster
