// The scheduler: who runs what, as a pure state machine. An input goes in, effects come out; it
// knows no network, disk, clock or thread, and of a run only its plan's units, their dependencies
// (through the plan), the versions of states, and who holds which.
//
// Idea. The plan says what can run; the scheduler cuts blocks of it, gives each to a worker, and
// takes the first result of each block that comes in, whoever it is from. A result is a pure
// function of its block, so a block may be given to several workers: when nothing is heard of one
// for too long (its lease ends), another one gets the block too. A state's version is the scan
// before which it stands; it travels as bytes unless the worker made it last.
//
//   plan ── block ──▶ waiting ──▶ given out ──▶ first result: kept, into the plan
//                        ▲            │
//                        └── lease ends, worker leaves or doesn't have it
//
// Invariants
//   1. Of each block exactly one result reaches the plan and is kept; doubled, late and foreign
//      ones, and those of another epoch, change nothing.
//   2. A block that is not done either waits or has been given out under a lease that runs: so
//      whatever workers and messages do, it is run at last if some worker answers at last.
//   3. A worker has at most threads * blocks_per_thread assignments that it is thought to have
//      before it; one that is silent gets none until it is heard. What a worker that isn't silent
//      has before it is under a lease, so that it is asked about what was lost.
//   4. What comes out is a function of the inputs' order, not of anything else.
//
// The order of decisions in one step:
//   step(input):
//     take the input in            (a result: plan, states, and Keep before anything is assigned)
//     while a worker has a thread without work and a block waits or the plan has one:
//       the one with the least before it, the lowest id among equals, gets
//         the first among the oldest that was passed over too often or of whose states it holds
//         most; else the oldest
//     while the one that is heard has room: the same, but for blocks of whose states
//       another one holds most
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
  std::uint64_t epoch = 1;  ///< of the run store: what assignments and deliveries carry
  BlockSizeOptions size{};
  /// So many blocks wait at a worker beside the one that each thread runs, so that it need not wait
  /// for a message; none where a scan takes longer than ahead_s_max, when a message costs nothing
  /// beside it.
  std::uint32_t blocks_ahead = 1;
  double ahead_s_max = 0.1;
  /// A lease is this long at least, and this many times what the blocks before a worker should
  /// take.
  double lease_s = 30;
  double lease_factor = 20;
  /// A silent worker is asked again after so long.
  double ask_every_s = 5;
};

/// Blocks that are compared for one that a worker holds states of.
inline constexpr std::size_t k_lookahead = 32;
/// A block is passed over for others at most this often.
inline constexpr std::uint32_t k_passed_over_max = 64;
/// A lease doubles with each copy of its block that was given out before, this often at most.
inline constexpr std::size_t k_lease_doublings_max = 10;

/// What has happened so far, for people.
struct Counts {
  std::uint64_t blocks = 0;   ///< done
  std::uint64_t scans = 0;    ///< in these
  std::uint64_t copies = 0;   ///< of blocks given out again after a lease or a worker ended
  std::uint64_t refused = 0;  ///< deliveries of another epoch, of blocks done, or that don't fit
  std::uint64_t states_sent = 0;
  std::uint64_t states_held = 0;     ///< of which a version number was enough
  std::uint64_t states_missing = 0;  ///< deliveries that said it wasn't
};

class Scheduler {
 public:
  /// Borrows the plan, which nobody else drives. REQUIRES: it is fresh, or has consumed what the
  /// run store holds, whose states are given by resume before the first step.
  Scheduler(plan::Plan& plan, const SchedulerOptions& options);

  /// A replica goes on before this scan with this state.
  void resume(const plan::ReplicaKey& replica, std::uint64_t next_scan, base::Bytes state);

  std::vector<Effect> step(Input input);

  /// The plan is finished, or a stop was asked for and everything given out has come back.
  bool ended() const { return plan_.finished() || (stopping_ && tasks_.empty()); }
  /// Threads of the workers that are heard.
  std::uint64_t threads() const { return threads_; }
  /// Assignments that nobody has brought back.
  std::size_t given_out() const { return assignments_.size(); }
  const Counts& counts() const { return counts_; }

 private:
  using TaskId = std::uint64_t;
  using AssignmentId = std::uint64_t;
  struct Task {
    plan::Block block;
    std::set<AssignmentId> leases;  ///< that run; none: it waits
    /// Who holds most of its members' states: nobody else comes to hold any before it is done.
    std::optional<WorkerId> preferred{};
    std::size_t given = 0;  ///< how often
    std::uint32_t passed_over = 0;
  };
  struct Given {
    WorkerId worker;
    TaskId task = 0;  ///< done perhaps, by another copy
    double lease_end_s = 0;
  };
  struct Worker {
    std::uint64_t incarnation = 0;
    std::uint32_t threads = 1;
    std::set<AssignmentId> before_it;
    std::optional<double> load;  ///< its place in roomy_
    bool silent = false;
    double asked_s = 0;
    std::uint64_t asked_up_to = 0;  ///< assignments below this were made before it was asked
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
  std::optional<double> now_s_;  ///< none before the first tick
  bool stopping_ = false;
  bool splits_ladders_ = false;  ///< as the last block that the plan gave
  TaskId next_task_ = 0;
  AssignmentId next_assignment_ = 0;
  std::map<TaskId, Task> tasks_;  ///< not done
  std::set<TaskId> waiting_;      ///< oldest first; exactly those without a lease
  std::map<AssignmentId, Given> assignments_;
  std::set<std::pair<double, AssignmentId>> leases_;  ///< (end, assignment)
  std::map<WorkerId, Worker> workers_;
  std::set<std::pair<double, WorkerId>> roomy_;  ///< (blocks before it per thread, worker)
  std::set<WorkerId> silent_;
  std::uint64_t threads_ = 0;
  std::map<plan::ReplicaKey, Replica> replicas_;
  std::vector<Effect> effects_;
  Counts counts_;
};

}  // namespace sleight::core
