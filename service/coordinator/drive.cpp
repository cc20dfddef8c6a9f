#include "service/coordinator/drive.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/base/check.h"

namespace sleight::coordinator {
namespace {

/// A late checkpoint is written when its cost is below this share of the time since the last.
constexpr double k_checkpoint_share_max = 0.05;

/// Scans per unit from the measured cost of a scan, smoothed. A unit is at most four times as long
/// as one that was measured, and scan 0, which makes no proposal, counts for nothing: a scan may be
/// a microsecond or a minute, and a stop must be answered soon either way.
class UnitSize {
 public:
  std::uint32_t scans() const { return scans_; }
  void measured(const plan::UnitResult& result) {
    const std::uint32_t moving = result.unit.scans - (result.unit.first_scan.value == 0 ? 1 : 0);
    if (moving == 0) return;
    const double cost_s = result.cost_s / moving;
    // Another rank measured it: what is no time tells nothing.
    if (!std::isfinite(cost_s) || cost_s < 0) return;
    scan_cost_s_ = scan_cost_s_ == 0 ? cost_s : 0.8 * scan_cost_s_ + 0.2 * cost_s;
    const double wanted = k_unit_target_s / std::max(scan_cost_s_, 1e-9);
    const double most = std::min<double>(k_unit_scans_max, 4.0 * result.unit.scans);
    scans_ = static_cast<std::uint32_t>(std::clamp(wanted, 1.0, most));
  }

 private:
  std::uint32_t scans_ = 1;
  double scan_cost_s_ = 0;
};

class Driver {
 public:
  Driver(plan::Plan& plan, store::RunStore& store, Executor& executor, const base::Clock& clock,
         const DriveOptions& options)
      : plan_(plan),
        store_(store),
        executor_(executor),
        clock_(clock),
        options_(options),
        begin_s_(clock.now_s()),
        checkpoint_s_(begin_s_) {}

  DriveOutcome run() {
    catch_up();
    DriveEnd end = DriveEnd::finished;
    while (!plan_.finished()) {
      if (const std::optional<DriveEnd> early = asked_to_stop()) {
        end = *early;
        break;
      }
      hand_out();
      CHECK_GT(executor_.outstanding(), 0U);
      take_in(executor_.wait(options_.report_every_s));
      report_now_and_then();
      checkpoint_now_and_then();
    }

    // Let what is running end, so that nothing computed is thrown away; what waits is dropped.
    executor_.drop_waiting();
    while (executor_.outstanding() > 0)
      take_in(executor_.wait(options_.report_every_s));
    store_.flush();
    if (plan_.finished()) end = DriveEnd::finished;
    if (options_.report) options_.report(progress());
    return {.end = end, .scans_common = plan_.scans_common(), .progress = progress()};
  }

 private:
  /// Brings the plan to where earlier sessions left the run.
  void catch_up() {
    for (store::ReplicaProgress& replica : store_.progress()) {
      std::uint64_t next_scan = 0;
      store_.replay(replica.replica,
                    [&](base::ScanIndex first, std::span<const plan::ScanRecord> records) {
                      plan_.consume(replica.replica, first, records);
                      next_scan = first.value + records.size();
                    });
      CHECK_EQ(next_scan, replica.next_scan);  // replay refuses a damaged store
      states_[replica.replica] = std::move(replica.state);
    }
    earlier_scans_ = plan_.scans_consumed();
  }

  std::optional<DriveEnd> asked_to_stop() const {
    if (options_.stop_requested && options_.stop_requested()) return DriveEnd::stop_requested;
    if (options_.time_limit_s > 0 && clock_.now_s() - begin_s_ >= options_.time_limit_s) {
      return DriveEnd::time_limit;
    }
    return std::nullopt;
  }

  void hand_out() {
    while (executor_.room() > 0) {
      // No unit is longer than what all chains have behind them: so they stay within a factor of
      // two of one another, and a run that is cut short has something to show of each.
      const std::uint64_t longest = std::max<std::uint64_t>(plan_.scans_common(), 1);
      const auto scans_max =
          static_cast<std::uint32_t>(std::min<std::uint64_t>(unit_size_.scans(), longest));
      const std::optional<plan::Unit> unit = plan_.next_unit(scans_max);
      if (!unit) return;
      executor_.submit(*unit, states_[unit->replica]);
    }
  }

  void take_in(std::vector<plan::UnitResult> results) {
    for (plan::UnitResult& result : results) {
      unit_size_.measured(result);
      plan_.consume(result.unit.replica, result.unit.first_scan, result.scans);
      states_[result.unit.replica] = result.state_after;
      for (const plan::ScanRecord& scan : result.scans)
        count(scan);
      store_.put(std::move(result));
    }
  }

  void count(const plan::ScanRecord& scan) {
    ++counted_.session_scans;
    if (scan.satisfied) ++counted_.session_satisfied;
    counted_.session_proposed +=
        std::accumulate(scan.proposed.begin(), scan.proposed.end(), std::uint64_t{0});
    counted_.session_accepted +=
        std::accumulate(scan.accepted.begin(), scan.accepted.end(), std::uint64_t{0});
  }

  Progress progress() const {
    Progress now = counted_;
    now.scans_done = earlier_scans_ + store_.committed();
    now.scans_total = plan_.scans_total().value_or(0);
    now.solutions = plan_.solutions_found();
    now.solutions_wanted = plan_.solutions_wanted().value_or(0);
    now.workers = executor_.workers();
    now.elapsed_s = clock_.now_s() - begin_s_;
    return now;
  }

  void report_now_and_then() {
    const double now_s = clock_.now_s();
    if (!options_.report || now_s - report_s_ < options_.report_every_s) return;
    report_s_ = now_s;
    options_.report(progress());
  }

  void checkpoint_now_and_then() {
    if (!options_.checkpoint || plan_.scans_common() == 0) return;
    const double now_s = clock_.now_s();
    const double since_s = now_s - checkpoint_s_;
    if (since_s < options_.checkpoint_every_s) return;
    if (checkpoint_cost_s_ > k_checkpoint_share_max * since_s) return;
    store_.flush();
    options_.checkpoint(plan_.scans_common());
    checkpoint_s_ = clock_.now_s();
    checkpoint_cost_s_ = checkpoint_s_ - now_s;
  }

  plan::Plan& plan_;
  store::RunStore& store_;
  Executor& executor_;
  const base::Clock& clock_;
  const DriveOptions& options_;
  std::map<plan::ReplicaKey, base::Bytes> states_;
  UnitSize unit_size_;
  Progress counted_;
  std::uint64_t earlier_scans_ = 0;
  double begin_s_;
  double report_s_ = 0;
  double checkpoint_s_;
  double checkpoint_cost_s_ = 0;
};

}  // namespace

DriveOutcome drive(plan::Plan& plan, store::RunStore& store, Executor& executor,
                   const base::Clock& clock, const DriveOptions& options) {
  return Driver(plan, store, executor, clock, options).run();
}

}  // namespace sleight::coordinator
