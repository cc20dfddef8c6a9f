// Scripts for the scheduler. Each line of a script is an input. The indented lines below it are its
// effects. Script::play() returns the script with the actual effects.
//
// Example:
//   join 1 threads=2
//     assign 1 #0 a@0+2 starts         worker 1 gets assignment 0: two scans of replica a from 0 on
//     assign 1 #1 [b@3 held, c@3 bytes]       a ladder's part, with how each state is sent
//   done 1 #0                          worker 1 delivers the assignment
//     keep a@0+2
//
// Inputs:   join W [threads=N] [incarnation=N]      leave W        tick T        stop
//           done W #N [lacking] [epoch=N] [cost=S] [scans=N] [wrong=replica|first|scans|members]
//           pong W [#N ...] [epoch=N]               resume a N     (before anything else)
// Effects:  assign, keep, ask. Changes without an effect: (refused), (ended).
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

/// A plan of listed blocks. A block waits for all earlier blocks of its replicas, and for those of
/// the replicas after `<`. Example: "a2 a [bc] d<a" has four blocks: two scans of a; one scan of a;
/// a ladder's part of b and c; a scan of d, after the blocks of a.
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

  /// Sets the first scan of a resumed replica.
  void begins_at(char replica, std::uint64_t scan) { next_scan_[replica] = scan; }

 private:
  struct Job {
    std::string replicas;
    std::string after;  ///< names of replicas
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

  /// Returns the script with its actual effects.
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

/// Plays the script and expects the effects that it lists.
void expect_goes(std::string_view plan, const SchedulerOptions& options, std::string_view script);

}  // namespace sleight::core
