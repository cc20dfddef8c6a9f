#include "tests/cluster/sim_worker.h"

#include <utility>

namespace sleight::cluster {
namespace {

HashWorkerOptions work_of(const Scenario& scenario, std::uint32_t id) {
  HashWorkerOptions work = scenario.work;
  work.id = id;
  return work;
}

}  // namespace

SimWorker::Process::Process(const Scenario& scenario, std::uint32_t id, base::ManualClock& clock)
    : units(work_of(scenario, id), clock),
      blocks(units, clock),
      wrong_blocks(scenario.mistake, blocks, units) {}

SimWorker::SimWorker(const Scenario& scenario, std::uint32_t id, EventQueue& events,
                     base::ManualClock& clock, Meter& meter, Send send)
    : scenario_(scenario),
      id_{id},
      threads_(scenario.threads_of(id)),
      events_(events),
      clock_(clock),
      meter_(meter),
      send_(std::move(send)) {}

void SimWorker::start() {
  if (is_alive()) return;
  ++incarnation_;
  process_ = std::make_unique<Process>(scenario_, id_.value, clock_);
  stalled_until_s_ = 0;
  heard_s_ = events_.now_s();
  say_hello();
  greet_now_and_then();
}

void SimWorker::die() {
  if (!is_alive()) return;
  meter_.change(events_.now_s(), -static_cast<int>(process_->running.size()));
  process_ = nullptr;
}

/// Runs the action now or after the stall, unless the process dies first.
void SimWorker::when_awake(const EventQueue::Action& action) {
  if (events_.now_s() >= stalled_until_s_) {
    action();
    return;
  }
  events_.at(stalled_until_s_, [this, action, incarnation = incarnation_] {
    if (is_alive() && incarnation == incarnation_) when_awake(action);
  });
}

void SimWorker::say_hello() {
  send_(core::Joined{.worker = id_, .incarnation = incarnation_, .threads = threads_});
}

void SimWorker::greet_now_and_then() {
  events_.after(scenario_.hello_every_s, [this, incarnation = incarnation_] {
    if (!is_alive() || incarnation != incarnation_) return;
    const bool has_none = process_->queue.empty() && process_->running.empty();
    const bool is_lonely = events_.now_s() - heard_s_ >= scenario_.hello_every_s;
    const bool is_awake = events_.now_s() >= stalled_until_s_;
    if (is_awake && (has_none || is_lonely)) say_hello();
    greet_now_and_then();
  });
}

void SimWorker::receive(const schema::Assignment& assignment) {
  if (!is_alive()) return;
  when_awake([this, assignment] {
    heard_s_ = events_.now_s();
    process_->queue.push_back(assignment);
    work();
  });
}

void SimWorker::receive(const schema::Ping& ping) {
  if (!is_alive()) return;
  when_awake([this, ping] {
    heard_s_ = events_.now_s();
    schema::Pong pong{.epoch = ping.epoch, .assignments = {}};
    for (const schema::Assignment& waiting : process_->queue) {
      if (waiting.epoch == ping.epoch) pong.assignments.push_back(waiting.assignment);
    }
    for (const auto& [epoch, assignment] : process_->running) {
      if (epoch == ping.epoch) pong.assignments.push_back(assignment);
    }
    send_(core::Answered{.worker = id_, .pong = std::move(pong)});
  });
}

void SimWorker::work() {
  while (process_->running.size() < threads_ && !process_->queue.empty()) {
    const schema::Assignment assignment = std::move(process_->queue.front());
    process_->queue.pop_front();
    const bool is_wrong = scenario_.mistake != Mistake::none;
    const plan::BlockWorker& worker =
        is_wrong ? static_cast<const plan::BlockWorker&>(process_->wrong_blocks) : process_->blocks;
    const double begin_s = clock_.now_s();
    schema::Delivery delivery{.epoch = assignment.epoch,
                              .assignment = assignment.assignment,
                              .results = worker.run(assignment.block, assignment.states),
                              .cache = worker.cache_use()};
    const double cost_s = clock_.now_s() - begin_s;
    const std::pair name(assignment.epoch, assignment.assignment);
    process_->running.insert(name);
    meter_.change(events_.now_s(), 1);
    events_.after(
        cost_s, [this, name, incarnation = incarnation_, delivery = std::move(delivery)]() mutable {
          if (!is_alive() || incarnation != incarnation_) return;
          when_awake([this, name, delivery = std::move(delivery)]() mutable {
            process_->running.erase(process_->running.find(name));
            meter_.change(events_.now_s(), -1);
            send_(core::Delivered{.worker = id_, .delivery = std::move(delivery)});
            work();
          });
        });
  }
}

}  // namespace sleight::cluster
