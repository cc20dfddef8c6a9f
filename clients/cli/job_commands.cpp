#include "clients/cli/job_commands.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "clients/cli/job_text.h"
#include "clients/cli/job_watch.h"
#include "clients/cli/service_json.h"
#include "clients/service_client/known_servers.h"
#include "clients/service_client/selected_jobs.h"
#include "clients/service_client/service_call.h"
#include "clients/terminal/output.h"
#include "clients/terminal/terminal.h"
#include "common/base/error.h"
#include "common/events/progress.h"

namespace sleight::cli {
namespace {

/// Maximum number of jobs listed in a confirmation question.
constexpr std::size_t k_asked_about_max = 10;

rpc::JobState state_of(const std::string& text) {
  const auto state = rpc::job_state_of(text);
  if (state && *state != rpc::JobState::unknown) return *state;
  terminal::refuse_usage(
      fmt::format("--state: unknown state '{}'; expected queued, starting, running, yielding, "
                  "held, done, failed or cancelled",
                  terminal::shown(text)));
}

rpc::JobPage read_pages(rpc::Client& client, rpc::ListAsk ask, const ListOptions& options) {
  rpc::JobPage all;
  while (true) {
    const std::size_t missing =
        options.all ? rpc::k_page_jobs_max : options.count - all.jobs.size();
    ask.count = static_cast<std::uint32_t>(std::min(missing, rpc::k_page_jobs_max));
    rpc::JobPage page = client.list(ask);
    std::ranges::move(page.jobs, std::back_inserter(all.jobs));
    all.total = page.total;
    all.cursor = std::move(page.cursor);
    if (all.cursor.empty() || (!options.all && all.jobs.size() >= options.count)) return all;
    ask.cursor = all.cursor;
  }
}

void print_page(const rpc::JobPage& page, const ListOptions& options) {
  if (options.json) {
    Json json{{"jobs", jobs_json(page.jobs, false)},
              {"total", page.total},
              {"after", page.cursor.empty() ? Json(nullptr) : Json(page.cursor)}};
    fmt::print("{}\n", indented(json));
    return;
  }
  if (page.jobs.empty()) {
    fmt::print("no jobs\n");
    return;
  }
  const bool with_users = std::ranges::any_of(
      page.jobs, [&](const rpc::JobView& job) { return job.user != page.jobs.front().user; });
  fmt::print("{}", job_table(page.jobs, {.width = terminal::width_of(stdout),
                                         .with_users = with_users || !options.user.empty(),
                                         .user_name = &terminal::name_of_user}));
  if (!page.cursor.empty()) {
    fmt::print("{} of {} jobs; to list all, add --all; to list the next page, add --after '{}'\n",
               events::grouped(page.jobs.size()), events::grouped(page.total),
               terminal::shown(page.cursor));
  }
}

int complete(const std::string& socket) {
  // Shell completion shows any output, so print nothing on errors.
  try {
    rpc::Client client(service_client::place_of(socket), {.call_s_max = 2});
    for (const rpc::JobView& job : client.list({.count = rpc::k_page_jobs_max}).jobs)
      fmt::print("{}\n", completion_line(job));
  } catch (const std::exception&) {
    return terminal::k_ok;
  }
  return terminal::k_ok;
}

/// Returns a note about a change if the job's state doesn't show the change. Empty: the state shows
/// it.
std::string words_of(const rpc::ChangeAsk& ask) {
  if (ask.kind == rpc::ChangeKind::pin) return "pinned";
  if (ask.kind == rpc::ChangeKind::unpin) return "not pinned";
  if (ask.kind == rpc::ChangeKind::set_priority) return fmt::format("priority {}", ask.priority);
  return {};
}

int watch_named(const std::string& socket, const JobsOptions& options, std::uint64_t from_number,
                bool quiet) {
  const std::vector<service_client::JobName> names = service_client::read_job_names(options.jobs);
  return service_client::with_service(socket, [&](rpc::Client& client) {
    return watch_jobs(client, views_of(client, names), from_number,
                      {.quiet = quiet, .json = options.json, .single = is_single_job(names)});
  });
}

/// Returns, for example, "17 (hi, done, 12 MB)".
std::string about(const rpc::JobView& job) {
  return fmt::format("{} ({}, {}, {})", job.id, name_of_job(job), rpc::name_of(job.state),
                     size_text(job.bytes));
}

void refuse_running_and_pinned(std::span<const rpc::JobView> jobs) {
  for (const rpc::JobView& job : jobs) {
    if (rpc::is_settled(job.state) && job.pinned) {
      throw base::Error(
          base::ExitCode::conflict,
          fmt::format("nothing deleted: job {} is pinned; to unpin it, run `sleight pin {} --off`",
                      job.id, job.id));
    }
    if (rpc::is_settled(job.state)) continue;
    throw base::Error(
        base::ExitCode::conflict,
        fmt::format("nothing deleted: job {} is {}; to cancel it first, run `sleight cancel {}`",
                    job.id, rpc::name_of(job.state), job.id));
  }
}

std::string question(std::span<const rpc::JobView> jobs) {
  std::vector<std::string> texts;
  for (const rpc::JobView& job : jobs.first(std::min(jobs.size(), k_asked_about_max)))
    texts.push_back(about(job));
  std::string text = fmt::format("Delete {}", fmt::join(texts, ", "));
  if (jobs.size() > k_asked_about_max)
    text += fmt::format(" and {} more", jobs.size() - k_asked_about_max);
  return text + ", with archives and logs?";
}

}  // namespace

rpc::ListAsk list_ask_of(const ListOptions& options) {
  rpc::ListAsk ask{
      .name_part = options.name, .oldest_first = options.oldest_first, .cursor = options.after};
  for (const std::string& state : options.states)
    ask.states.push_back(state_of(state));
  if (options.mine) ask.user = ::getuid();
  if (!options.user.empty()) {
    if (options.mine) terminal::refuse_usage("--mine and --user can't be combined");
    ask.user = terminal::user_of(options.user);
    if (!ask.user)
      terminal::refuse_usage(
          fmt::format("--user: no user '{}' on this machine", terminal::shown(options.user)));
  }
  if (!options.group.empty()) {
    const std::vector<service_client::JobName> names =
        service_client::read_job_names(std::span(&options.group, 1));
    const auto* group = std::get_if<rpc::GroupId>(&names.front());
    if (group == nullptr)
      terminal::refuse_usage(
          fmt::format("--group: expected a group such as g5, found '{}'", options.group));
    ask.group = *group;
  }
  return ask;
}

int list_jobs(const std::string& socket, const ListOptions& options) {
  if (options.complete) return complete(socket);
  const rpc::ListAsk ask = list_ask_of(options);
  return service_client::with_service(socket, [&](rpc::Client& client) {
    print_page(read_pages(client, ask, options), options);
    return terminal::k_ok;
  });
}

int show_status(const std::string& socket, const StatusOptions& options) {
  const std::vector<service_client::JobName> names = service_client::read_job_names(options.jobs);
  return service_client::with_service(socket, [&](rpc::Client& client) {
    const std::vector<rpc::JobView> jobs = views_of(client, names, options.history);
    if (options.json) {
      fmt::print("{}\n", indented(jobs_json(jobs, is_single_job(names), options.history)));
      return terminal::k_ok;
    }
    for (const rpc::JobView& job : jobs) {
      fmt::print("{}{}", &job == jobs.data() ? "" : "\n", job_text(job));
      if (options.history) fmt::print("{}", history_text(job));
    }
    return terminal::k_ok;
  });
}

int watch(const std::string& socket, const WatchOptions& options) {
  return watch_named(socket, options, options.from_number, false);
}

int wait(const std::string& socket, const JobsOptions& options) {
  return watch_named(socket, options, 1, true);
}

int change(const std::string& socket, const JobsOptions& options, const rpc::ChangeAsk& ask) {
  const std::vector<service_client::JobName> names = service_client::read_job_names(options.jobs);
  return service_client::with_service(socket, [&](rpc::Client& client) {
    service_client::TouchedJobs touched = service_client::change(client, names, ask);
    const std::string words = words_of(ask);
    for (rpc::Touched& one : touched.done) {
      if (!words.empty()) one.words = words;
      if (!options.json) fmt::print("{}\n", touched_line(one));
    }
    if (options.json)
      fmt::print("{}\n", indented(touched_json(touched.done, is_single_job(names))));
    int code = terminal::k_ok;
    for (const service_client::RefusedName& one : touched.refused) {
      terminal::complain(
          fmt::format("sleight: {}: {}", one.name, service_client::words_of(one.refusal)));
      code = static_cast<int>(service_client::exit_code_of(one.refusal.kind));
    }
    return code;
  });
}

rpc::Extension extension_of(const ExtendOptions& options) {
  std::vector<rpc::Extension> given;
  const auto add = [&](rpc::ExtendBy by, const auto& number) {
    if (number) given.push_back({.by = by, .to = static_cast<double>(*number)});
  };
  add(rpc::ExtendBy::scans, options.scans);
  add(rpc::ExtendBy::rounds, options.rounds);
  add(rpc::ExtendBy::solutions, options.solutions);
  add(rpc::ExtendBy::odds, options.odds);
  if (given.size() != 1)
    terminal::refuse_usage("expected exactly one of --scans, --rounds, --solutions and --odds");
  return given.front();
}

int delete_jobs(const std::string& socket, const DeleteOptions& options) {
  const std::vector<service_client::JobName> names = service_client::read_job_names(options.jobs);
  return service_client::with_service(socket, [&](rpc::Client& client) {
    const std::vector<rpc::JobView> jobs = views_of(client, names);
    refuse_running_and_pinned(jobs);
    if (!options.yes && terminal::can_ask() && !terminal::ask(question(jobs))) {
      terminal::complain("nothing deleted");
      return terminal::k_ok;
    }
    // Delete the checked jobs one by one even if a group was named. Otherwise jobs that weren't
    // checked might be deleted.
    std::vector<rpc::Touched> touched;
    for (const rpc::JobView& job : jobs) {
      std::ranges::move(
          client.change({.target = rpc::Target::of(job.id), .kind = rpc::ChangeKind::erase}),
          std::back_inserter(touched));
      if (!options.json) fmt::print("deleted {}\n", about(job));
    }
    if (options.json) fmt::print("{}\n", indented(touched_json(touched, is_single_job(names))));
    return terminal::k_ok;
  });
}

}  // namespace sleight::cli
