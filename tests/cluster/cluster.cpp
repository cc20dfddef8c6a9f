#include "tests/cluster/cluster.h"

#include <algorithm>
#include <utility>

namespace sleight::cluster {
namespace {

/// `utilisation_amid` is measured while the share of finished scans is between these numbers.
constexpr double k_marks[] = {0.2, 0.8};
/// Number of assignments between two checks of the run's progress.
constexpr std::uint64_t k_note_every = 32;

void add(core::Counts& sum, const core::Counts& counts) {
  sum.blocks += counts.blocks;
  sum.scans += counts.scans;
  sum.copies += counts.copies;
  sum.refused += counts.refused;
  sum.states_sent += counts.states_sent;
  sum.states_held += counts.states_held;
  sum.states_missing += counts.states_missing;
}

bool is_weather(Fault::Kind kind) {
  return kind == Fault::Kind::messages_lost || kind == Fault::Kind::messages_twice ||
         kind == Fault::Kind::messages_late;
}

}  // namespace

Cluster::Cluster(const Case& of)
    : case_(of),
      scenario_(of.scenario),
      scans_(static_cast<double>(of.expected.scans())),
      network_(events_, scenario_.seed, scenario_.latency),
      dice_(scenario_.seed, Dice::Part::coordinator),
      store_(scenario_.seed, scenario_.mistake) {
  for (std::uint32_t id = 0; id < scenario_.workers; ++id) {
    const auto send = [this](core::Input input) {
      network_.send([this, input = std::move(input)] {
        if (coordinator_) coordinator_->receive(input);
      });
    };
    workers_.push_back(
        std::make_unique<SimWorker>(scenario_, id, events_, work_clock_, meter_, send));
  }
}

Outcome Cluster::run(double limit_s) {
  // Don't start workers that join later.
  std::vector<bool> is_late(workers_.size());
  for (const Fault& fault : scenario_.faults) {
    if (fault.kind == Fault::Kind::workers_join)
      std::fill_n(is_late.begin() + fault.first_worker, fault.workers, true);
  }
  events_.at(0, [this] { begin_session(); });
  for (const auto& worker : workers_) {
    if (!is_late[worker->id().value]) events_.at(0, [&worker] { worker->start(); });
  }
  for (const Fault& fault : scenario_.faults)
    events_.at(fault.at_s, [this, &fault] { strike(fault); });
  outcome_.quiet_s = quiet_from(scenario_.faults);
  events_.at(outcome_.quiet_s, [this] { calm_down(); });

  const double last_s = outcome_.quiet_s + limit_s;
  while (!outcome_.is_finished && events_.now_s() <= last_s && events_.run_next())
    ++outcome_.events;

  outcome_.end_s = events_.now_s();
  outcome_.digest = digest_of(store_.durable());
  outcome_.violation = store_.violation();
  outcome_.difference = difference(case_.expected, store_.durable());
  double threads = 0;
  for (std::uint32_t id = 0; id < scenario_.workers; ++id)
    threads += scenario_.threads_of(id);
  outcome_.utilisation = case_.work_s / (threads * outcome_.end_s);
  if (marks_.size() == std::size(k_marks)) {
    const double worked_s = marks_[1].thread_s - marks_[0].thread_s;
    outcome_.utilisation_amid = worked_s / (threads * (marks_[1].at_s - marks_[0].at_s));
  }
  return outcome_;
}

void Cluster::begin_session() {
  const std::optional<std::uint64_t> epoch = store_.open(events_.now_s());
  if (!epoch) {
    end_session();
    return;
  }
  ++outcome_.sessions;
  SimCoordinator::Outside outside{
      .assign =
          [this](core::WorkerId worker, schema::Assignment assignment) {
            SimWorker& to = *workers_[worker.value];
            network_.send([&to, assignment = std::move(assignment)] { to.receive(assignment); });
            note_progress();
          },
      .ask =
          [this](core::WorkerId worker, schema::Ping ping) {
            SimWorker& to = *workers_[worker.value];
            network_.send([&to, ping] { to.receive(ping); });
          },
      .left = [this] { end_session(); },
      .finished =
          [this] {
            outcome_.is_finished = true;
            add(outcome_.counts, coordinator_->counts());
          }};
  coordinator_ =
      std::make_shared<SimCoordinator>(scenario_, *epoch, store_, events_, std::move(outside));
  const std::shared_ptr<SimCoordinator> session = coordinator_;
  session->begin();
}

/// Ends the dead coordinator's session and starts another one.
void Cluster::end_session() {
  if (coordinator_) {
    coordinator_->die();
    add(outcome_.counts, coordinator_->counts());
    coordinator_ = nullptr;
  }
  events_.after(dice_.uniform(0, scenario_.restart_s_max), [this] { begin_session(); });
}

void Cluster::note_progress() {
  if (marks_.size() == std::size(k_marks) || assigned_++ % k_note_every != 0) return;
  const auto done = static_cast<double>(coordinator_->plan().scans_consumed());
  if (done < k_marks[marks_.size()] * scans_) return;
  marks_.push_back({.at_s = events_.now_s(), .thread_s = meter_.thread_s(events_.now_s())});
}

void Cluster::for_workers(const Fault& fault, const std::function<void(SimWorker&)>& action) {
  for (std::uint32_t i = 0; i < fault.workers; ++i)
    action(*workers_[fault.first_worker + i]);
}

void Cluster::strike(const Fault& fault) {
  using Kind = Fault::Kind;
  if (is_weather(fault.kind)) {
    change_weather(fault, true);
    events_.after(fault.for_s, [this, &fault] { change_weather(fault, false); });
  } else if (fault.kind == Kind::workers_die) {
    for_workers(fault, [&](SimWorker& worker) {
      worker.die();
      if (!fault.is_noticed) return;
      network_.send([this, id = worker.id()] {
        if (coordinator_) coordinator_->receive(core::Left{id});
      });
    });
    if (fault.is_for_ever) return;
    events_.after(fault.for_s, [this, &fault] {
      for_workers(fault, [](SimWorker& worker) { worker.start(); });
    });
  } else if (fault.kind == Kind::workers_stall) {
    for_workers(fault, [&](SimWorker& worker) { worker.stall(events_.now_s() + fault.for_s); });
  } else if (fault.kind == Kind::workers_join) {
    for_workers(fault, [](SimWorker& worker) { worker.start(); });
  } else if (fault.kind == Kind::coordinator_dies) {
    if (coordinator_) end_session();
  } else if (fault.kind == Kind::coordinator_stops) {
    if (coordinator_) coordinator_->receive(core::StopAsked{});
  } else if (fault.kind == Kind::dies_before_commit) {
    store_.crash_at_next_commit(SimStore::Crash::before);
  } else if (fault.kind == Kind::dies_in_commit) {
    store_.crash_at_next_commit(SimStore::Crash::within);
  } else if (fault.kind == Kind::dies_after_commit) {
    store_.crash_at_next_commit(SimStore::Crash::after);
  } else {
    store_.fill_until(events_.now_s() + fault.for_s);
  }
}

/// If bursts of bad weather overlap, only the worst burst has an effect.
void Cluster::change_weather(const Fault& fault, bool begins) {
  if (begins) {
    bad_weather_.push_back(fault);
  } else {
    const auto over = std::ranges::find_if(bad_weather_, [&](const Fault& blows) {
      return blows.kind == fault.kind && blows.at_s == fault.at_s && blows.odds == fault.odds;
    });
    bad_weather_.erase(over);
  }
  Weather weather;
  for (const Fault& blows : bad_weather_) {
    double& odds = blows.kind == Fault::Kind::messages_lost    ? weather.lost
                   : blows.kind == Fault::Kind::messages_twice ? weather.doubled
                                                               : weather.late;
    odds = std::max(odds, blows.odds);
    weather.late_s_max = std::max(weather.late_s_max, blows.for_s);
  }
  network_.set(weather);
}

/// Ends all faults, and starts a worker if none is alive.
void Cluster::calm_down() {
  store_.crash_at_next_commit(SimStore::Crash::none);
  const bool is_anyone =
      std::ranges::any_of(workers_, &SimWorker::is_alive,
                          [](const auto& worker) -> const SimWorker& { return *worker; });
  if (!is_anyone) workers_.front()->start();
}

double liveness_bound_s(const Case& of) {
  const core::SchedulerOptions& options = of.scenario.scheduler;
  const double longest_lease_s = std::max(options.lease_s, options.lease_factor * of.longest_s) *
                                 static_cast<double>(1U << core::k_lease_doublings_max);
  return longest_lease_s + 2 * of.work_s + of.longest_s + 1;
}

}  // namespace sleight::cluster
