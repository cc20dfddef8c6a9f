#include "service/coordinator/drive.h"

#include <map>
#include <numeric>
#include <utility>
#include <variant>

#include "common/base/check.h"

namespace sleight::coordinator {
namespace {

class Driver {
 public:
  Driver(plan::Plan& plan, store::RunStore& store, Crew& crew, const base::Clock& clock,
         const DriveOptions& options)
      : plan_(plan),
        store_(store),
        crew_(crew),
        clock_(clock),
        options_(options),
        scheduler_(plan, {.epoch = store.epoch()}),
        begin_s_(clock.now_s()) {}

  DriveOutcome run() {
    catch_up();
    DriveEnd end = DriveEnd::finished;
    carry_out(tick());
    stop_if_asked(end);  // before any assignment
    for (const core::Joined& member : crew_.members())
      carry_out(member);
    while (!scheduler_.ended() && !is_grace_over()) {
      for (core::Input& input : crew_.receive(options_.report_every_s))
        carry_out(std::move(input));
      carry_out(tick());
      report_now_and_then();
      stop_if_asked(end);
    }
    store_.flush();
    if (plan_.finished() && end != DriveEnd::simulation_failed) end = DriveEnd::finished;
    if (options_.report) options_.report(progress());
    return {.end = end, .reached = cut_of(plan_), .progress = progress(), .handling = handling()};
  }

 private:
  /// Brings plan and scheduler to the state that earlier sessions reached.
  void catch_up() {
    std::map<plan::ReplicaKey, std::uint64_t> next_scans;
    // replay_all() throws if the store is damaged.
    store_.replay_all([&](const plan::ReplicaKey& replica, base::ScanIndex first,
                          std::span<const plan::ScanRecord> records) {
      plan_.consume(replica, first, records);
      if (options_.consumed) options_.consumed(replica, first, records);
      for (const plan::ScanRecord& record : records)
        counted_.failures.add(record.failures);
      next_scans[replica] = first.value + records.size();
    });
    for (store::ReplicaProgress& replica : store_.progress()) {
      CHECK_EQ(next_scans[replica.replica], replica.next_scan);
      scheduler_.resume(replica.replica, replica.next_scan, std::move(replica.state));
    }
    earlier_scans_ = plan_.scans_consumed();
  }

  /// Passes the input to the scheduler and carries out its effects.
  void carry_out(core::Input input) {
    if (const auto* delivered = std::get_if<core::Delivered>(&input)) {
      // A worker's threads may deliver results out of order, so never decrease the count.
      plan::CacheUse& known = caches_[delivered->worker];
      const plan::CacheUse& said = delivered->delivery.cache;
      if (said.hits + said.misses >= known.hits + known.misses) known = said;
    }
    for (core::Effect& effect : scheduler_.step(std::move(input))) {
      if (auto* keep = std::get_if<core::Keep>(&effect)) {
        for (plan::UnitResult& result : keep->results)
          put(std::move(result));
      } else if (auto* assign = std::get_if<core::Assign>(&effect)) {
        crew_.send(assign->worker, std::move(assign->assignment));
      } else {
        const auto& ask = std::get<core::Ask>(effect);
        crew_.send(ask.worker, ask.ping);
      }
    }
    const plan::Finds finds = plan_.finds();
    if (finds.found > counted_.finds.found) counted_.found_s = clock_.now_s() - begin_s_;
    counted_.finds = finds;
    // If a search has all its finds, report at once.
    if (!std::exchange(had_finds_, has_finds()) && had_finds_) tell_standing();
  }

  core::Tick tick() const { return {.now_s = clock_.now_s()}; }

  /// Stops once. Blocks in progress may finish, so that their results aren't lost.
  void stop_if_asked(DriveEnd& end) {
    if (end != DriveEnd::finished) return;
    const std::optional<DriveEnd> early = asked_to_stop();
    if (!early) return;
    end = *early;
    stop_s_ = clock_.now_s();
    if (end == DriveEnd::stop_requested && options_.stopping) options_.stopping();
    carry_out(core::StopAsked{});
  }

  bool is_grace_over() const {
    return stop_s_ && clock_.now_s() - *stop_s_ >= options_.stop_grace_s;
  }

  std::optional<DriveEnd> asked_to_stop() const {
    if (options_.strict && counted_.failures.total() > 0) return DriveEnd::simulation_failed;
    if (options_.stop_requested && options_.stop_requested()) return DriveEnd::stop_requested;
    if (options_.time_limit_s > 0 && clock_.now_s() - begin_s_ >= options_.time_limit_s) {
      return DriveEnd::time_limit;
    }
    return std::nullopt;
  }

  void put(plan::UnitResult result) {
    counted_.session_simulations += result.simulations;
    if (!result.unit.draws_prior()) {
      for (const plan::ScanRecord& scan : result.scans)
        count(scan);
    }
    if (options_.consumed)
      options_.consumed(result.unit.replica, result.unit.first_scan, result.scans);
    if (options_.failed) {
      for (const plan::FailedSimulation& failed : result.failed)
        options_.failed(result.unit.replica, failed);
    }
    store_.put(std::move(result));
  }

  void count(const plan::ScanRecord& scan) {
    ++counted_.session_scans;
    if (scan.satisfied) ++counted_.session_satisfied;
    counted_.failures.add(scan.failures);
    counted_.session_proposed +=
        std::accumulate(scan.proposed.begin(), scan.proposed.end(), std::uint64_t{0});
    counted_.session_accepted +=
        std::accumulate(scan.accepted.begin(), scan.accepted.end(), std::uint64_t{0});
  }

  events::Progress progress() const {
    events::Progress now = counted_;
    now.scans_done = earlier_scans_ + store_.committed();
    now.scans_total = plan_.scans_total().value_or(0);
    now.solutions = plan_.solutions_found();
    now.solutions_wanted = plan_.solutions_wanted().value_or(0);
    now.round_trips = plan_.round_trips();
    now.odds = plan_.odds();
    if (now.odds.log_p) *now.odds.log_p -= options_.log_natural_throw;
    now.prior_draws = plan_.prior_draws();
    now.prior_draws_wanted = plan_.prior_draws_wanted();
    now.workers = scheduler_.threads();
    now.elapsed_s = clock_.now_s() - begin_s_;
    return now;
  }

  Handling handling() const {
    Handling all{.counts = scheduler_.counts(), .traffic = crew_.traffic(), .cache = {}};
    for (const auto& [worker, cache] : caches_) {
      all.cache.hits += cache.hits;
      all.cache.misses += cache.misses;
      all.cache.evictions += cache.evictions;
      all.cache.bytes += cache.bytes;
      all.cache.bytes_max += cache.bytes_max;
    }
    return all;
  }

  void report_now_and_then() {
    const double now_s = clock_.now_s();
    if (now_s - report_s_ < options_.report_every_s) return;
    report_s_ = now_s;
    if (options_.report) options_.report(progress());
    tell_standing();
  }

  bool has_finds() const {
    return counted_.finds.wanted > 0 && counted_.finds.found >= counted_.finds.wanted;
  }

  void tell_standing() const {
    if (!options_.standing) return;
    const request::Cut now = cut_of(plan_);
    options_.standing({.reached = now,
                       .has_solution = now.found > 0 || plan_.solutions_found() > 0,
                       .has_finds = had_finds_,
                       .workers = scheduler_.threads()});
  }

  plan::Plan& plan_;
  store::RunStore& store_;
  Crew& crew_;
  const base::Clock& clock_;
  const DriveOptions& options_;
  core::Scheduler scheduler_;
  std::map<core::WorkerId, plan::CacheUse> caches_;
  events::Progress counted_;
  std::uint64_t earlier_scans_ = 0;
  double begin_s_;
  std::optional<double> stop_s_;  ///< time of the stop request
  double report_s_ = 0;
  bool had_finds_ = false;  ///< a search has all requested finds
};

}  // namespace

request::Cut cut_of(const plan::Plan& plan) {
  const plan::Finds finds = plan.finds();
  return {.scans = plan.scans_common(),
          .found = finds.found,
          .relaxed = finds.relaxed,
          .prior_draws = plan.prior_draws()};
}

DriveOutcome drive(plan::Plan& plan, store::RunStore& store, Crew& crew, const base::Clock& clock,
                   const DriveOptions& options) {
  return Driver(plan, store, crew, clock, options).run();
}

}  // namespace sleight::coordinator
