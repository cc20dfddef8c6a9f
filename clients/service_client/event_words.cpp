#include "clients/service_client/event_words.h"

#include <fmt/format.h>

#include <variant>

#include "clients/terminal/output.h"
#include "common/events/progress.h"
#include "common/events/run_end.h"

namespace sleight::service_client {
namespace {

using events::grouped;

std::string words(rpc::JobId, const events::Phase& phase) {
  return terminal::shown(phase.words);
}

std::string words(rpc::JobId, const events::Progress& progress) {
  return terminal::shown(events::progress_line("progress:", progress));
}

std::string words(rpc::JobId, const events::Solution& solution) {
  if (!solution.in_proportion) {
    return fmt::format("found {}: start {}, log p {:.4g}", grouped(solution.nth),
                       grouped(solution.scan), solution.log_p);
  }
  return fmt::format("solution {} (in the model's proportions): chain {}, scan {}, log p {:.4g}",
                     grouped(solution.nth), solution.chain, grouped(solution.scan), solution.log_p);
}

std::string words(rpc::JobId job, const events::Failure& failure) {
  std::string text = fmt::format("simulation FAILED: {}, chain {}, replica {}, scan {}",
                                 terminal::shown(failure.simulation), failure.chain,
                                 failure.replica, grouped(failure.scan));
  if (!failure.file.empty())
    text += fmt::format("; for a file that repeats the failure, run `sleight fetch {} --failures`",
                        job);
  return text;
}

std::string words(rpc::JobId, const events::RoundEnded& round) {
  std::string text = fmt::format("round {} of chain {} ended: {} scans", grouped(round.round),
                                 round.chain, grouped(round.scans));
  if (round.swaps) text += fmt::format(", {:.0f}% of swaps accepted", *round.swaps * 100);
  if (round.round_trips) text += fmt::format(", {} round trips", grouped(*round.round_trips));
  return text;
}

std::string words(rpc::JobId, const events::ArchiveWritten& archive) {
  std::string text = "archive written:";
  if (archive.found > 0) text += fmt::format(" {} found,", grouped(archive.found));
  return text + fmt::format(" {} scans, digest {}", grouped(archive.scans),
                            terminal::shown(archive.digest));
}

std::string words(rpc::JobId, const events::RunEnd& end) {
  std::string text = fmt::format("session {} ended: {}", end.epoch, events::name_of(end.end));
  if (!end.words.empty()) text += ". " + terminal::shown_on_one_line(end.words);
  return text;
}

}  // namespace

std::string words_of_event(rpc::JobId job, const events::RunEvent& event) {
  return std::visit([&](const auto& what) { return words(job, what); }, event.what);
}

std::string words_of_change(const rpc::StateChange& change) {
  std::string text(rpc::name_of(change.state));
  if (change.attempt > 1) text += fmt::format(", start {}", change.attempt);
  if (!change.reason.empty()) text += ": " + terminal::shown_on_one_line(change.reason);
  return text;
}

}  // namespace sleight::service_client
