#include "service/core/scheduler.h"

#include <algorithm>
#include <ranges>

#include "common/base/check.h"

namespace sleight::core {
namespace {

std::uint64_t scans_of(const plan::Block& block) {
  return block.ladder ? std::max<std::uint64_t>(block.ladder->scans_max, block.members.size())
                      : block.members.front().scans;
}

}  // namespace

Scheduler::Scheduler(plan::Plan& plan, const SchedulerOptions& options)
    : plan_(plan), options_(options), size_(options.size) {}

void Scheduler::resume(const plan::ReplicaKey& replica, std::uint64_t next_scan,
                       base::Bytes state) {
  replicas_[replica] = {.version = next_scan, .state = std::move(state), .holder = {}};
}

std::vector<Effect> Scheduler::step(Input input) {
  effects_.clear();
  std::visit([this](auto& kind) { take(kind); }, input);
  std::optional<WorkerId> heard_of;
  if (const auto* delivered = std::get_if<Delivered>(&input)) heard_of = delivered->worker;
  if (const auto* joined = std::get_if<Joined>(&input)) heard_of = joined->worker;
  if (const auto* answered = std::get_if<Answered>(&input)) heard_of = answered->worker;
  hand_out(heard_of);
  return std::exchange(effects_, {});
}

void Scheduler::take(const Joined& input) {
  const auto known = workers_.find(input.worker);
  if (known != workers_.end() && known->second.incarnation == input.incarnation) {
    heard(input.worker);
    return;
  }
  forget_worker(input.worker);
  Worker& worker = workers_[input.worker];
  worker.incarnation = input.incarnation;
  worker.threads = std::max(input.threads, 1U);
  threads_ += worker.threads;
  place(input.worker);
}

void Scheduler::take(const Left& input) {
  forget_worker(input.worker);
}

void Scheduler::take(Delivered& input) {
  heard(input.worker);
  schema::Delivery& delivery = input.delivery;
  const auto given = assignments_.find(delivery.assignment);
  if (delivery.epoch != options_.epoch || given == assignments_.end()) {
    ++counts_.refused;
    return;
  }
  // The results are right even if the worker has been replaced since.
  const auto task = tasks_.find(given->second.task);
  std::optional<plan::Block> block;  // The block that the results complete.
  if (task == tasks_.end()) {
    ++counts_.refused;
  } else if (delivery.results.empty()) {
    // The worker lacks a state. The next worker gets the state's bytes.
    ++counts_.states_missing;
    task->second.preferred.reset();
    for (const plan::Unit& member : task->second.block.members) {
      if (!member.starts) replicas_.at(member.replica).holder.reset();
    }
  } else if (!fits(task->second.block, delivery.results)) {
    ++counts_.refused;
  } else {
    block = std::move(task->second.block);
    done(task->first);
  }
  // If this delivery hasn't completed the block, the block waits again. After a stop, it is dropped
  // instead.
  end_lease(delivery.assignment);
  take_back(delivery.assignment);
  if (block) accept(input.worker, *block, std::move(delivery.results));
}

bool Scheduler::fits(const plan::Block& block, const std::vector<plan::UnitResult>& results) const {
  if (results.size() != block.members.size()) return false;
  std::uint64_t scans = 0;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const plan::Unit& asked = block.members[i];
    const plan::Unit& run = results[i].unit;
    if (run.replica != asked.replica || run.first_scan != asked.first_scan) return false;
    if (run.scans == 0 || run.scans != results[i].scans.size()) return false;
    if (!block.ladder && run.scans != asked.scans) return false;
    if (block.ladder && run.first_scan.value + run.scans > block.ladder->end_scan) return false;
    scans += run.scans;
  }
  return scans <= scans_of(block);
}

void Scheduler::accept(WorkerId worker, const plan::Block& block,
                       std::vector<plan::UnitResult> results) {
  const auto holder = workers_.contains(worker) ? std::optional(worker) : std::nullopt;
  std::uint64_t scans = 0;
  std::uint64_t moving = 0;
  double cost_s = 0;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const plan::UnitResult& result = results[i];
    plan_.consume(result.unit.replica, result.unit.first_scan, result.scans);
    replicas_[result.unit.replica] = {.version = result.unit.first_scan.value + result.unit.scans,
                                      .state = result.state_after,
                                      .holder = holder};
    scans += result.unit.scans;
    moving += result.unit.scans - (block.members[i].starts ? 1 : 0);
    cost_s += result.cost_s;
  }
  size_.measured(scans, moving, cost_s);
  ++counts_.blocks;
  counts_.scans += scans;
  effects_.push_back(Keep{std::move(results)});
}

/// Removes a completed block. From now on, other copies of the block are ignored.
void Scheduler::done(TaskId task) {
  waiting_.erase(task);
  tasks_.erase(task);
}

void Scheduler::take(const Answered& input) {
  const auto found = workers_.find(input.worker);
  if (found == workers_.end() || input.pong.epoch != options_.epoch) return;
  heard(input.worker);

  // If the worker doesn't list an assignment, either the assignment or its result was lost.
  const std::set<AssignmentId> has(input.pong.assignments.begin(), input.pong.assignments.end());
  const std::set<AssignmentId> before_it = found->second.before_it;
  for (const AssignmentId id : before_it) {
    if (id >= found->second.asked_up_to) continue;
    const auto task = tasks_.find(assignments_.at(id).task);
    if (!has.contains(id)) {
      end_lease(id);
      take_back(id);
      continue;
    }
    // The worker is only slow: renew the lease, and remove the block from the waiting blocks.
    if (task == tasks_.end()) {
      renew_lease(id, options_.lease_s);
      continue;
    }
    renew_lease(id, lease_s(found->second, task->second));
    waiting_.erase(task->first);
    task->second.leases.insert(id);
  }
}

void Scheduler::take(const Tick& input) {
  if (now_s_) {
    CHECK_GE(input.now_s, *now_s_);
  } else {
    // The first tick sets the clock. Shift the leases that were given out before this tick.
    for (const auto& [end_s, id] : std::exchange(leases_, {})) {
      assignments_.at(id).lease_end_s += input.now_s;
      leases_.emplace(assignments_.at(id).lease_end_s, id);
    }
  }
  now_s_ = input.now_s;
  while (!leases_.empty() && leases_.begin()->first <= input.now_s) {
    const AssignmentId id = leases_.begin()->second;
    const WorkerId worker = assignments_.at(id).worker;
    end_lease(id);
    Worker& late = workers_.at(worker);
    if (late.silent) continue;
    late.silent = true;
    threads_ -= late.threads;
    silent_.insert(worker);
    place(worker);
    ask(worker);
  }
  for (const WorkerId worker : silent_) {
    if (input.now_s - workers_.at(worker).asked_s >= options_.ask_every_s) ask(worker);
  }
}

void Scheduler::take(const StopAsked&) {
  stopping_ = true;
  for (const TaskId task : waiting_)
    tasks_.erase(task);
  waiting_.clear();
}

void Scheduler::ask(WorkerId id) {
  Worker& worker = workers_.at(id);
  worker.asked_s = now_s_.value_or(0);
  worker.asked_up_to = next_assignment_;
  effects_.push_back(Ask{.worker = id, .ping = {.epoch = options_.epoch}});
}

void Scheduler::heard(WorkerId id) {
  const auto found = workers_.find(id);
  if (found == workers_.end() || !found->second.silent) return;
  found->second.silent = false;
  threads_ += found->second.threads;
  silent_.erase(id);
  place(id);
  // The worker may have lost assignments. Renew their ended leases. When the leases end again, the
  // scheduler asks about the assignments.
  for (const AssignmentId assignment : found->second.before_it) {
    const Given& given = assignments_.at(assignment);
    if (leases_.contains({given.lease_end_s, assignment})) continue;
    const auto task = tasks_.find(given.task);
    renew_lease(assignment,
                task == tasks_.end() ? options_.lease_s : lease_s(found->second, task->second));
  }
}

void Scheduler::forget_worker(WorkerId id) {
  const auto found = workers_.find(id);
  if (found == workers_.end()) return;
  const std::set<AssignmentId> before_it = found->second.before_it;
  for (const AssignmentId assignment : before_it) {
    end_lease(assignment);
    take_back(assignment);
  }
  if (found->second.load) roomy_.erase({*found->second.load, id});
  if (silent_.erase(id) == 0) threads_ -= found->second.threads;
  workers_.erase(found);
  for (auto& [key, replica] : replicas_) {
    if (replica.holder == id) replica.holder.reset();
  }
  for (auto& [key, task] : tasks_) {
    if (task.preferred == id) task.preferred.reset();
  }
}

/// Ends the assignment's claim on its block. The block waits again if no other assignment has it.
void Scheduler::end_lease(AssignmentId id) {
  Given& given = assignments_.at(id);
  leases_.erase({given.lease_end_s, id});
  const auto task = tasks_.find(given.task);
  if (task == tasks_.end() || task->second.leases.erase(id) == 0) return;
  if (!task->second.leases.empty()) return;
  if (stopping_) {
    tasks_.erase(task);
  } else {
    waiting_.insert(task->first);
  }
}

void Scheduler::renew_lease(AssignmentId id, double lease_s) {
  Given& given = assignments_.at(id);
  leases_.erase({given.lease_end_s, id});
  given.lease_end_s = now_s_.value_or(0) + lease_s;
  leases_.emplace(given.lease_end_s, id);
}

/// Removes an assignment from its worker. REQUIRES: the assignment's lease has ended.
void Scheduler::take_back(AssignmentId id) {
  const WorkerId worker = assignments_.at(id).worker;
  assignments_.erase(id);
  workers_.at(worker).before_it.erase(id);
  place(worker);
}

bool Scheduler::has_room(const Worker& worker) const {
  const double scan_s = size_.expected_s(1);
  const bool ahead = scan_s < options_.ahead_s_max;
  const std::size_t per_thread = 1 + (ahead ? options_.blocks_ahead : 0);
  return !worker.silent && worker.before_it.size() < worker.threads * per_thread;
}

void Scheduler::place(WorkerId id) {
  Worker& worker = workers_.at(id);
  if (worker.load) roomy_.erase({*worker.load, id});
  worker.load.reset();
  if (!has_room(worker)) return;
  worker.load = static_cast<double>(worker.before_it.size()) / worker.threads;
  roomy_.emplace(*worker.load, id);
}

void Scheduler::fetch() {
  // If there are several workers, a block may wait for the worker that holds its states.
  const std::size_t wanted = workers_.size() > 1 ? k_lookahead : 1;
  while (waiting_.size() < wanted) {
    // A unit gets at most as many scans as every chain already has. So chains differ at most by a
    // factor of two in their scans, and an early stop leaves results of every chain.
    const std::uint64_t blocks = assignments_.size() + waiting_.size() + 1;
    const BlockSize::Threads threads{.all = threads_, .at_work = std::min(threads_, blocks)};
    std::optional<plan::Block> block =
        plan_.next_block(size_.limits(threads, std::max<std::uint64_t>(plan_.scans_common(), 1)));
    if (!block) return;
    const TaskId id = next_task_++;
    splits_ladders_ = block->ladder.has_value();
    const std::optional<WorkerId> preferred = holder_of_most(*block);
    tasks_[id] = {.block = *std::move(block), .leases = {}, .preferred = preferred};
    waiting_.insert(waiting_.end(), id);
  }
}

void Scheduler::hand_out(std::optional<WorkerId> heard_of) {
  // Give work to workers with idle threads.
  while (!roomy_.empty() && roomy_.begin()->first < 1) {
    const WorkerId worker = roomy_.begin()->second;
    if (!has_work()) {
      // If a ladder's blocks are smaller, other threads get more work. Blocks of plain chains
      // don't.
      if (heard_of && splits_ladders_) size_.starved();
      return;
    }
    give(worker, take_waiting(choose(worker)));
  }
  // Give more blocks to the worker that sent this input, unless another worker holds their states.
  const auto has_more_room = [&] {
    const auto found = workers_.find(*heard_of);
    return found != workers_.end() && has_room(found->second);
  };
  while (heard_of && has_more_room() && has_work()) {
    const TaskId task = choose(*heard_of);
    const std::optional<WorkerId>& preferred = tasks_.at(task).preferred;
    if (preferred && *preferred != *heard_of) return;
    give(*heard_of, take_waiting(task));
  }
}

bool Scheduler::has_work() {
  if (stopping_ || plan_.finished()) return false;
  fetch();
  // If the plan has no block and none is in progress, the run would never end.
  CHECK(!tasks_.empty());
  return !waiting_.empty();
}

Scheduler::TaskId Scheduler::take_waiting(TaskId task) {
  waiting_.erase(task);
  size_.fed();
  return task;
}

Scheduler::TaskId Scheduler::choose(WorkerId worker) {
  for (const TaskId id : waiting_ | std::views::take(k_lookahead)) {
    const Task& task = tasks_.at(id);
    if (task.preferred != worker && task.passed_over < k_passed_over_max) continue;
    for (const TaskId older : waiting_ | std::views::take_while([id](TaskId t) { return t < id; }))
      ++tasks_.at(older).passed_over;
    return id;
  }
  return *waiting_.begin();
}

std::optional<WorkerId> Scheduler::holder_of_most(const plan::Block& block) const {
  std::map<WorkerId, std::size_t> held;
  for (const plan::Unit& member : block.members) {
    const auto found = replicas_.find(member.replica);
    if (found != replicas_.end() && found->second.holder) ++held[*found->second.holder];
  }
  const auto most =
      std::ranges::max_element(held, {}, [](const auto& entry) { return entry.second; });
  if (most == held.end()) return std::nullopt;
  return most->first;
}

double Scheduler::lease_s(const Worker& worker, const Task& task) const {
  const double work_s =
      size_.expected_s(scans_of(task.block)) * static_cast<double>(worker.before_it.size() + 1);
  const auto doublings = static_cast<int>(std::min(task.given, k_lease_doublings_max));
  return std::max(options_.lease_s, options_.lease_factor * work_s) *
         static_cast<double>(1U << static_cast<unsigned>(doublings));
}

void Scheduler::give(WorkerId id, TaskId task_id) {
  Worker& worker = workers_.at(id);
  Task& task = tasks_.at(task_id);
  const AssignmentId assignment = next_assignment_++;
  const double end_s = now_s_.value_or(0) + lease_s(worker, task);
  assignments_[assignment] = {.worker = id, .task = task_id, .lease_end_s = end_s};
  leases_.emplace(end_s, assignment);
  worker.before_it.insert(assignment);
  place(id);
  task.leases.insert(assignment);
  if (task.given++ > 0) ++counts_.copies;

  // If the worker was the last to make the state, send only the state's version, which is the
  // member's first scan.
  std::vector<plan::GivenState> states;
  for (const plan::Unit& member : task.block.members) {
    plan::GivenState& state = states.emplace_back();
    if (member.starts) {
      const base::BytesView start = plan_.start_state(member.replica);
      if (!start.empty()) state.emplace(start.begin(), start.end());
      continue;
    }
    const Replica& replica = replicas_.at(member.replica);
    CHECK_EQ(replica.version, member.first_scan.value);
    if (replica.holder == id) {
      ++counts_.states_held;
      continue;
    }
    ++counts_.states_sent;
    state = replica.state;
  }
  effects_.push_back(Assign{.worker = id,
                            .assignment = {.epoch = options_.epoch,
                                           .assignment = assignment,
                                           .block = task.block,
                                           .states = std::move(states)}});
}

}  // namespace sleight::core
