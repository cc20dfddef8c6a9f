// Watching jobs until they end: `watch`, `wait`, and both at the end of `submit`.
//
// On a terminal one progress line renews itself on stderr; elsewhere it is a plain line now and
// then. Events and changes of state are lines on stdout, in words or as JSON. The watch goes on
// over lost connections and restarted servers, which stderr hears of, and ends when all jobs have
// ended.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "clients/terminal/progress_printer.h"
#include "common/base/error.h"
#include "common/rpc/client.h"

namespace sleight::cli {

struct WatchLook {
  bool quiet = false;  ///< the end alone is told
  bool json =
      false;  ///< of events: a line each; when quiet: the jobs at last, as `status` has them
  bool single = false;  ///< one job was named alone: without its id before each line
};

/// Prints what a watch hears, and remembers how the jobs ended. For one thread.
class WatchPrinter final : public rpc::WatchSink {
 public:
  WatchPrinter(std::span<const rpc::JobView> jobs, const WatchLook& look);

  bool changed(rpc::JobId job, const rpc::StateChange& change) override;
  bool happened(const rpc::WatchedEvent& event) override;
  bool settled(rpc::JobId job) override;
  bool refused(rpc::JobId job, const rpc::Refusal& refusal) override;
  bool lost(const std::string& words) override;
  bool found_again() override;

  /// Ends the progress line.
  void finish();
  /// Of all that has settled: failed before cancelled before refused before done.
  base::ExitCode exit_code() const;

 private:
  void print(rpc::JobId job, const std::string& words);
  terminal::ProgressPrinter& printer(rpc::JobId job);

  WatchLook look_;
  std::map<rpc::JobId, std::string> names_;
  std::map<rpc::JobId, std::unique_ptr<terminal::ProgressPrinter>> printers_;
  std::map<rpc::JobId, rpc::JobState> states_;  ///< the newest
  std::optional<base::ExitCode> refused_;
};

/// Watches these jobs, events from a number on (1: all), until they end or Ctrl-C comes; then tells
/// how each stands. Returns the exit code: 0 done, 10 failed, 11 cancelled, 130 interrupted.
int watch_jobs(rpc::Client& client, std::span<const rpc::JobView> jobs, std::uint64_t from_number,
               const WatchLook& look);

}  // namespace sleight::cli
