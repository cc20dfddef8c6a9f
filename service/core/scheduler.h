// The scheduler decides which worker runs which block, as a pure state machine. Each step takes an
// input and returns effects. The scheduler uses no network, disk, clock or thread. The scheduler
// knows the plan's units, the versions of states, and which worker holds which state.
//
// Idea. The scheduler requests blocks from the plan, gives each block to a worker, and accepts each
// block's first result from any worker. A result is a pure function of its block, so several
// workers may run the same block. If a worker is silent for too long, its lease ends, and another
// worker also gets the block. A state's version is the number of the scan that follows it. If the
// worker was the last to make the state, the state's version is sent, otherwise its bytes.
//
//   plan ── block ──▶ waiting ──▶ given out ──▶ first result: stored, into the plan
//                        ▲            │
//                        └── lease ends, worker leaves or doesn't have it
//
// Invariants
//   1. Exactly one result of each block reaches the plan and is stored. Other results change
//      nothing: repeated, late or foreign results, and results of another epoch.
//   2. Until a block is done, it either waits or is assigned under a running lease. So whichever
//      workers or messages fail, the block completes if some worker eventually answers.
//   3. As far as the scheduler knows, a worker has at most threads * blocks_per_thread assignments.
//      A silent worker gets no assignments until it sends a message. If a worker isn't silent, each
//      of its assignments has a lease. So the scheduler asks about lost assignments.
//   4. Effects depend only on the order of inputs.
//
// A step decides in this order:
//   1. Process the input. A result changes the plan and the states, and leads to a Keep, before
//      anything is assigned.
//   2. This step repeats while a worker has an idle thread, and a block waits or the plan has one.
//      Choose the worker with the fewest assignments per thread; among equals, the lowest id. Look
//      through the oldest blocks for one that prefers this worker or was passed over too often.
//      Give the worker the first such block; if there is none, the oldest block. A block prefers
//      the worker that holds most of its states.
//   3. While the worker that sent the input has room, give it blocks in the same way. Stop at a
//      block that prefers another worker.
//
// Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "common/plan/plan.h"
#include "service/core/block_size.h"
#include "service/core/messages.h"

namespace sleight::core {

struct SchedulerOptions {
  std::uint64_t epoch = 1;  ///< Epoch of the run store, which assignments and deliveries carry.
  BlockSizeOptions size{};
  /// Number of blocks that wait at a worker for each of its threads. With such a block, the thread
  /// need not wait for a message. 0 if a scan takes longer than ahead_s_max.
  std::uint32_t blocks_ahead = 1;
  double ahead_s_max = 0.1;
  /// A lease lasts at least lease_s. A lease also lasts at least lease_factor times the expected
  /// duration of the worker's work.
  double lease_s = 30;
  double lease_factor = 20;
  /// Interval at which a silent worker is asked for its assignments.
  double ask_every_s = 5;
};

/// The scheduler searches this many waiting blocks for one that prefers the worker.
inline constexpr std::size_t k_lookahead = 32;
/// Maximum number of times that other blocks overtake a block.
inline constexpr std::uint32_t k_passed_over_max = 64;
/// Each earlier copy of a block doubles the lease. There are at most this many doublings.
inline constexpr std::size_t k_lease_doublings_max = 10;

struct Counts {
  std::uint64_t blocks = 0;   ///< Completed blocks.
  std::uint64_t scans = 0;    ///< Scans of completed blocks.
  std::uint64_t copies = 0;   ///< Blocks given out again after a lease or a worker ended.
  std::uint64_t refused = 0;  ///< Deliveries that are late, foreign or don't fit.
  std::uint64_t states_sent = 0;
  std::uint64_t states_held = 0;     ///< States sent as a version number alone.
  std::uint64_t states_missing = 0;  ///< Deliveries that reported a missing state.
};

class Scheduler {
 public:
  /// Borrows the plan; nothing else may drive it. REQUIRES: either the plan is fresh, or it has
  /// consumed the run store's results and resume() sets their states before the first step.
  Scheduler(plan::Plan& plan, const SchedulerOptions& options);

  /// Sets a replica's state. The replica continues from this state at scan `next_scan`.
  void resume(const plan::ReplicaKey& replica, std::uint64_t next_scan, base::Bytes state);

  std::vector<Effect> step(Input input);

  /// Whether the run has ended: the plan is finished, or all assignments have come back after a
  /// stop request.
  bool ended() const { return plan_.finished() || (stopping_ && tasks_.empty()); }
  /// Number of threads, without those of silent workers.
  std::uint64_t threads() const { return threads_; }
  std::size_t given_out() const { return assignments_.size(); }
  const Counts& counts() const { return counts_; }

 private:
  using TaskId = std::uint64_t;
  using AssignmentId = std::uint64_t;
  struct Task {
    plan::Block block;
    std::set<AssignmentId> leases;  ///< Running leases. Empty: the block waits.
    /// The worker that holds most of the members' states.
    std::optional<WorkerId> preferred{};
    std::size_t given = 0;  ///< Number of times given out.
    std::uint32_t passed_over = 0;
  };
  struct Given {
    WorkerId worker;
    TaskId task = 0;  ///< Another copy may have completed it.
    double lease_end_s = 0;
  };
  struct Worker {
    std::uint64_t incarnation = 0;
    std::uint32_t threads = 1;
    std::set<AssignmentId> before_it;
    std::optional<double> load;  ///< Place in roomy_.
    bool silent = false;
    double asked_s = 0;
    std::uint64_t asked_up_to = 0;  ///< Assignments below this precede the last question.
  };
  struct Replica {
    std::uint64_t version = 0;
    base::Bytes state;
    std::optional<WorkerId> holder;
  };

  void take(const Joined& input);
  void take(const Left& input);
  void take(Delivered& input);
  void take(const Answered& input);
  void take(const Tick& input);
  void take(const StopAsked& input);
  bool fits(const plan::Block& block, const std::vector<plan::UnitResult>& results) const;
  void accept(WorkerId worker, const plan::Block& block, std::vector<plan::UnitResult> results);
  void done(TaskId task);
  void hand_out(std::optional<WorkerId> heard_of);
  bool has_work();
  TaskId take_waiting(TaskId task);
  void fetch();
  TaskId choose(WorkerId worker);
  void give(WorkerId worker, TaskId task);
  void take_back(AssignmentId assignment);
  void end_lease(AssignmentId assignment);
  void renew_lease(AssignmentId assignment, double lease_s);
  void forget_worker(WorkerId worker);
  void heard(WorkerId worker);
  void ask(WorkerId worker);
  void place(WorkerId worker);
  std::optional<WorkerId> holder_of_most(const plan::Block& block) const;
  bool has_room(const Worker& worker) const;
  double lease_s(const Worker& worker, const Task& task) const;

  plan::Plan& plan_;
  SchedulerOptions options_;
  BlockSize size_;
  std::optional<double> now_s_;  ///< Empty before the first tick.
  bool stopping_ = false;
  bool splits_ladders_ = false;  ///< Whether the plan's last block was part of a ladder.
  TaskId next_task_ = 0;
  AssignmentId next_assignment_ = 0;
  std::map<TaskId, Task> tasks_;  ///< Blocks that aren't done.
  std::set<TaskId> waiting_;      ///< Blocks without a lease, oldest first.
  std::map<AssignmentId, Given> assignments_;
  std::set<std::pair<double, AssignmentId>> leases_;  ///< (end, assignment).
  std::map<WorkerId, Worker> workers_;
  std::set<std::pair<double, WorkerId>> roomy_;  ///< (assignments per thread, worker).
  std::set<WorkerId> silent_;
  std::uint64_t threads_ = 0;
  std::map<plan::ReplicaKey, Replica> replicas_;
  std::vector<Effect> effects_;
  Counts counts_;
};

}  // namespace sleight::core
