// Scripts for the scheduler: a line is an input; the lines below it, indented, are what comes of
// it. Playing a script gives it back with what really came.
//
//   join 1 threads=2
//     assign 1 #0 a@0+2 starts         worker 1 gets assignment 0: two scans of replica a from 0 on
//     assign 1 #1 [b@3 held, c@3 bytes]       a ladder's part; which states go along, and how
//   done 1 #0                          it delivers what it was asked for
//     keep a@0+2
//
// Inputs:   join W [threads=N] [incarnation=N]      leave W        tick T        stop
//           done W #N [lacking] [epoch=N] [cost=S] [scans=N] [wrong=replica|first|scans|members]
//           pong W [#N ...] [epoch=N]               resume a N     (before anything else)
// Effects:  assign, keep, ask; and in brackets what changed without one: refused, ended.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/plan/plan.h"
#include "service/core/scheduler.h"

namespace sleight::core {

/// Blocks in the order of a list, each as soon as the earlier ones of its replicas are done, and
/// those that it names: "a2 a [bc] d<a" is two scans of a, then one, a part of a ladder with b and
/// c, and d when a's are done.
class ListedPlan final : public plan::Plan {
 public:
  explicit ListedPlan(std::string_view list);

  std::optional<plan::Unit> next_unit(std::uint32_t) override { return std::nullopt; }
  std::optional<plan::Block> next_block(const plan::BlockLimits&) override;
  void consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
               std::span<const plan::ScanRecord> records) override;
  bool finished() const override;
  std::uint64_t scans_common() const override { return 1000; }
  std::uint64_t solutions_found() const override { return 0; }
  std::vector<plan::Solution> solutions_between(std::uint64_t, std::uint64_t) const override {
    return {};
  }
  std::optional<std::uint64_t> solutions_wanted() const override { return std::nullopt; }
  std::uint64_t scans_consumed() const override { return 0; }
  std::optional<std::uint64_t> scans_total() const override { return std::nullopt; }

  /// From a run store.
  void begins_at(char replica, std::uint64_t scan) { next_scan_[replica] = scan; }

 private:
  struct Job {
    std::string replicas;
    std::string after;  ///< replicas too
    bool is_part = false;
    std::uint32_t scans = 1;
    bool handed_out = false;
    std::size_t consumed = 0;  ///< members
    bool done() const { return consumed == replicas.size(); }
  };
  std::vector<Job> jobs_;
  std::map<char, std::uint64_t> next_scan_;
};

class Script {
 public:
  Script(std::string_view plan, const SchedulerOptions& options)
      : plan_(plan), options_(options), scheduler_(plan_, options) {}

  /// The script as it really goes.
  std::string play(std::string_view script);
  const Counts& counts() const { return scheduler_.counts(); }

 private:
  struct Line;
  void take(const Line& line);
  Delivered delivery(const Line& line) const;
  std::string printed(const Effect& effect);

  ListedPlan plan_;
  SchedulerOptions options_;
  Scheduler scheduler_;
  std::map<std::uint64_t, plan::Block> given_;  ///< by assignment
  std::uint64_t refused_ = 0;
  bool ended_ = false;
  std::string played_;
};

/// Expects that a script goes as it says.
void expect_goes(std::string_view plan, const SchedulerOptions& options, std::string_view script);

}  // namespace sleight::core
