#include "tests/cluster/sim_coordinator.h"

#include <algorithm>
#include <span>
#include <utility>
#include <variant>

namespace sleight::cluster {
namespace {

/// Number of records replayed at a time.
constexpr std::size_t k_batch = 64;

core::SchedulerOptions options_of(const Scenario& scenario, std::uint64_t epoch) {
  core::SchedulerOptions options = scenario.scheduler;
  options.epoch = epoch;
  return options;
}

}  // namespace

SimCoordinator::SimCoordinator(const Scenario& scenario, std::uint64_t epoch, SimStore& store,
                               EventQueue& events, Outside outside)
    : scenario_(scenario),
      store_(store),
      events_(events),
      outside_(std::move(outside)),
      plan_(scenario.make_plan()),
      scheduler_(*plan_, options_of(scenario, epoch)),
      wrong_(scenario.mistake, epoch),
      busy_until_s_(events.now_s()) {}

void SimCoordinator::begin() {
  catch_up();
  tick();
  end_if_over();
}

void SimCoordinator::catch_up() {
  const sampling::Replaced wrong(formulas_with(scenario_.mistake));
  for (const auto& [key, replica] : store_.durable().replicas) {
    std::span<const plan::ScanRecord> left(replica.scans);
    base::Bytes state = replica.state;
    if (scenario_.mistake == Mistake::scan_short && left.size() > 1)
      left = left.first(left.size() - 1);
    if (scenario_.mistake == Mistake::stale_state && left.size() > 1)
      state = left[left.size() - 2].state;
    std::uint64_t next_scan = replica.first_scan;
    while (!left.empty()) {
      const auto batch = left.first(std::min(left.size(), k_batch));
      plan_->consume(key, base::ScanIndex{next_scan}, batch);
      next_scan += batch.size();
      left = left.subspan(batch.size());
    }
    scheduler_.resume(key, next_scan, std::move(state));
  }
}

void SimCoordinator::at(double time_s, std::function<void(SimCoordinator&)> action) {
  events_.at(time_s, [weak = weak_from_this(), action = std::move(action)] {
    const std::shared_ptr<SimCoordinator> self = weak.lock();
    if (self && !self->is_dead_) action(*self);
  });
}

void SimCoordinator::receive(core::Input input) {
  busy_until_s_ = std::max(busy_until_s_, events_.now_s()) + scenario_.handling_s;
  at(busy_until_s_, [input = std::move(input)](SimCoordinator& self) mutable {
    self.carry_out(std::move(input));
  });
}

void SimCoordinator::tick() {
  carry_out(core::Tick{events_.now_s()});
  at(events_.now_s() + scenario_.tick_s, [](SimCoordinator& self) { self.tick(); });
}

std::vector<core::Effect> SimCoordinator::step(core::Input input) {
  const sampling::Replaced wrong(formulas_with(scenario_.mistake));
  return scheduler_.step(std::move(input));
}

void SimCoordinator::carry_out(core::Input input) {
  if (auto* delivered = std::get_if<core::Delivered>(&input)) wrong_.take(delivered->delivery);
  for (core::Effect& effect : step(std::move(input))) {
    if (auto* keep = std::get_if<core::Keep>(&effect)) {
      for (plan::UnitResult& result : keep->results)
        store_.put(std::move(result));
      commit_soon();
    } else if (auto* assign = std::get_if<core::Assign>(&effect)) {
      wrong_.given(assign->assignment);
      outside_.assign(assign->worker, std::move(assign->assignment));
    } else {
      const auto& ask = std::get<core::Ask>(effect);
      outside_.ask(ask.worker, ask.ping);
    }
  }
  end_if_over();
}

void SimCoordinator::commit_soon() {
  if (std::exchange(commit_waits_, true)) return;
  at(events_.now_s() + scenario_.commit_every_s, [](SimCoordinator& self) { self.commit(); });
}

void SimCoordinator::commit() {
  commit_waits_ = false;
  if (is_dead_ || !store_.has_pending() || store_.commit(events_.now_s())) return;
  die();
  outside_.left();
}

void SimCoordinator::end_if_over() {
  if (is_dead_ || !scheduler_.ended()) return;
  commit();
  if (is_dead_) return;
  die();
  if (plan_->finished()) {
    outside_.finished();
  } else {
    outside_.left();  // a stop was requested
  }
}

}  // namespace sleight::cluster
