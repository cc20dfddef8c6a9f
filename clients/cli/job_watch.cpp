#include "clients/cli/job_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <variant>

#include "clients/cli/job_text.h"
#include "clients/cli/service_json.h"
#include "clients/service_client/event_words.h"
#include "clients/service_client/service_call.h"
#include "clients/terminal/interruption.h"

namespace sleight::cli {
namespace {

/// Prints a line and flushes it, so that a pipe's reader sees it at once.
void print_now(const std::string& line) {
  fmt::print("{}\n", line);
  std::fflush(stdout);
}

std::string id_list(std::span<const rpc::JobView> jobs) {
  if (jobs.size() > 1 && jobs.front().group) {
    const auto same = [&](const rpc::JobView& job) { return job.group == jobs.front().group; };
    if (std::ranges::all_of(jobs, same)) return fmt::format("g{}", *jobs.front().group);
  }
  constexpr std::size_t k_listed_max = 8;
  if (jobs.size() > k_listed_max) return "JOB...";
  std::string list;
  for (const rpc::JobView& job : jobs)
    list += fmt::format("{}{}", list.empty() ? "" : " ", job.id);
  return list;
}

/// Returns the jobs' state after the watch. Leaves out deleted jobs, because they were already
/// reported.
std::vector<rpc::JobView> final_views(rpc::Client& client, std::span<const rpc::JobView> jobs) {
  std::vector<rpc::JobView> views;
  for (const rpc::JobView& job : jobs) {
    try {
      views.push_back(client.status(job.id));
    } catch (const rpc::RefusedError&) {
      continue;
    }
  }
  return views;
}

void tell_the_end(rpc::Client& client, std::span<const rpc::JobView> jobs, const WatchLook& look) {
  // The JSON events already show how the jobs ended.
  if (look.json && !look.quiet) return;
  const std::vector<rpc::JobView> views = final_views(client, jobs);
  if (look.json) {
    print_now(indented(jobs_json(views, look.single)));
    return;
  }
  for (const rpc::JobView& view : views)
    print_now(end_line(view));
}

}  // namespace

WatchPrinter::WatchPrinter(std::span<const rpc::JobView> jobs, const WatchLook& look)
    : look_(look) {
  for (const rpc::JobView& job : jobs) {
    const std::string name = name_of_job(job);
    names_[job.id] = look.single ? name : fmt::format("{} {}", job.id, name);
    states_[job.id] = job.state;
  }
}

terminal::ProgressPrinter& WatchPrinter::printer(rpc::JobId job) {
  auto& printer = printers_[job];
  if (!printer) printer = std::make_unique<terminal::ProgressPrinter>(names_[job], stderr);
  return *printer;
}

void WatchPrinter::print(rpc::JobId job, const std::string& words) {
  for (auto& [id, printer] : printers_)
    printer->clear();
  print_now(look_.single ? words : fmt::format("{}  {}", job, words));
}

bool WatchPrinter::changed(rpc::JobId job, const rpc::StateChange& change) {
  states_[job] = change.state;
  if (look_.quiet) return true;
  if (look_.json) {
    print_now(on_one_line(change_json(job, change)));
  } else {
    print(job, service_client::words_of_change(change));
  }
  return true;
}

bool WatchPrinter::happened(const rpc::WatchedEvent& event) {
  if (look_.quiet) return true;
  if (look_.json) {
    const Json json = event_json(event.job, event.line);
    if (!json.is_null()) print_now(on_one_line(json));
    return true;
  }
  // If a newer service sent an unknown event, it can't be printed as text. With --json it is
  // printed.
  if (!event.event) return true;
  if (const auto* progress = std::get_if<events::Progress>(&event.event->what)) {
    printer(event.job).show(*progress);
  } else if (const auto* phase = std::get_if<events::Phase>(&event.event->what)) {
    printer(event.job).say(terminal::shown(phase->words));
  } else {
    print(event.job, service_client::words_of_event(event.job, *event.event));
  }
  return true;
}

bool WatchPrinter::settled(rpc::JobId job) {
  if (look_.json && !look_.quiet) {
    print_now(on_one_line({{"job", job.value},
                           {"number", 0},
                           {"kind", "settled"},
                           {"state", rpc::name_of(states_[job])}}));
  }
  return true;
}

bool WatchPrinter::refused(rpc::JobId job, const rpc::Refusal& refusal) {
  finish();
  terminal::complain(fmt::format("sleight: {}: {}", job, service_client::words_of(refusal)));
  if (look_.json && !look_.quiet) {
    print_now(on_one_line({{"job", job.value},
                           {"number", 0},
                           {"kind", "refused"},
                           {"refusal", rpc::name_of(refusal.kind)},
                           {"words", service_client::words_of(refusal)}}));
  }
  states_.erase(job);
  if (!refused_) refused_ = service_client::exit_code_of(refusal.kind);
  return true;
}

bool WatchPrinter::lost(const std::string& words) {
  finish();
  if (!look_.quiet)
    terminal::complain(
        fmt::format("lost the connection to the server, reconnecting: {}", terminal::shown(words)));
  return true;
}

bool WatchPrinter::found_again() {
  if (!look_.quiet) terminal::complain("reconnected to the server");
  return true;
}

void WatchPrinter::finish() {
  for (auto& [id, printer] : printers_)
    printer->clear();
}

base::ExitCode WatchPrinter::exit_code() const {
  const auto is_any = [&](rpc::JobState state) {
    return std::ranges::any_of(states_, [&](const auto& entry) { return entry.second == state; });
  };
  if (is_any(rpc::JobState::failed)) return base::ExitCode::job_failed;
  if (is_any(rpc::JobState::cancelled)) return base::ExitCode::job_cancelled;
  return refused_.value_or(base::ExitCode::ok);
}

int watch_jobs(rpc::Client& client, std::span<const rpc::JobView> jobs, std::uint64_t from_number,
               const WatchLook& look) {
  if (jobs.size() > rpc::k_watch_jobs_max) {
    throw base::Error(
        base::ExitCode::usage,
        fmt::format("{} jobs exceed the maximum of {} jobs that can be watched at once",
                    jobs.size(), rpc::k_watch_jobs_max));
  }
  std::vector<rpc::WatchPoint> points;
  for (const rpc::JobView& job : jobs)
    points.push_back({.job = job.id, .event = from_number - 1});
  WatchPrinter printer(jobs, look);
  const terminal::EndsWithItsReader ends_with_its_reader;
  const terminal::Interruption interruption([&client] { client.interrupt(); });
  const rpc::Waited how = client.watch(points, printer);
  printer.finish();
  if (how == rpc::Waited::interrupted) {
    const std::string ids = id_list(jobs);
    terminal::complain(
        fmt::format("{} running. To watch again, run `sleight watch {}`; to cancel, run `sleight "
                    "cancel {}`.",
                    jobs.size() == 1 ? "The job keeps" : "The jobs keep", ids, ids));
    return static_cast<int>(base::ExitCode::interrupted);
  }
  tell_the_end(client, jobs, look);
  return static_cast<int>(printer.exit_code());
}

}  // namespace sleight::cli
