// Watches jobs until they end, for `watch`, `wait` and `submit`.
//
// On a terminal, stderr has one progress line that is updated; otherwise it gets a plain line now
// and then. Events and state changes are printed on stdout, as lines of text or JSON. The watch
// survives lost connections and server restarts, which it reports on stderr. The watch ends when
// all jobs have ended.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "clients/terminal/progress_printer.h"
#include "common/base/error.h"
#include "common/rpc/client.h"

namespace sleight::cli {

struct WatchLook {
  bool quiet = false;   ///< print only the end
  bool json = false;    ///< events: one line each; with `quiet`: the final jobs as in `status`
  bool single = false;  ///< a single job was named: no id before each line
};

/// Prints what a watch receives, and stores how the jobs ended. Not thread-safe.
class WatchPrinter final : public rpc::WatchSink {
 public:
  WatchPrinter(std::span<const rpc::JobView> jobs, const WatchLook& look);

  bool changed(rpc::JobId job, const rpc::StateChange& change) override;
  bool happened(const rpc::WatchedEvent& event) override;
  bool settled(rpc::JobId job) override;
  bool refused(rpc::JobId job, const rpc::Refusal& refusal) override;
  bool lost(const std::string& words) override;
  bool found_again() override;

  void finish();
  /// Returns the exit code of the job that ended worst. From worst to best: failed, cancelled,
  /// refused, done.
  base::ExitCode exit_code() const;

 private:
  void print(rpc::JobId job, const std::string& words);
  terminal::ProgressPrinter& printer(rpc::JobId job);

  WatchLook look_;
  std::map<rpc::JobId, std::string> names_;
  std::map<rpc::JobId, std::unique_ptr<terminal::ProgressPrinter>> printers_;
  std::map<rpc::JobId, rpc::JobState> states_;  ///< the newest state
  std::optional<base::ExitCode> refused_;
};

/// Watches these jobs until they end or until Ctrl-C. The first printed event has the number
/// `from_number` (1: all events). After the watch, prints the status of each job. Returns the exit
/// code: 0 done, 10 failed, 11 cancelled, 130 interrupted.
int watch_jobs(rpc::Client& client, std::span<const rpc::JobView> jobs, std::uint64_t from_number,
               const WatchLook& look);

}  // namespace sleight::cli
