#include "clients/service_client/selected_jobs.h"

#include <fmt/format.h>

#include <set>
#include <utility>

#include "common/base/error.h"

namespace sleight::service_client {
namespace {

bool is_absence(const rpc::Refusal& refusal) {
  return refusal.kind == rpc::RefusalKind::not_found || refusal.kind == rpc::RefusalKind::gone;
}

/// Calls `each` for every number in a range. Skips numbers without a job.
void for_each_job(const JobRange& range, const std::function<void(rpc::JobId)>& each) {
  bool is_any = false;
  for (std::uint64_t number = range.first; number <= range.last; ++number) {
    try {
      each(rpc::JobId{number});
      is_any = true;
    } catch (const rpc::RefusedError& error) {
      if (!is_absence(error.refusal())) throw;
    }
  }
  if (!is_any) {
    throw base::Error(base::ExitCode::usage,
                      fmt::format("no job of yours in {}..{}", range.first, range.last));
  }
}

}  // namespace

std::vector<JobName> read_job_names(std::span<const std::string> texts) {
  auto names = job_names_of(texts);
  if (!names) throw base::Error(base::ExitCode::usage, names.error());
  return std::move(names).value();
}

std::vector<rpc::JobView> jobs_of(rpc::Client& client, rpc::GroupId group) {
  std::vector<rpc::JobView> jobs;
  rpc::ListAsk ask{.group = group, .oldest_first = true, .count = rpc::k_page_jobs_max};
  do {
    rpc::JobPage page = client.list(ask);
    for (rpc::JobView& job : page.jobs)
      jobs.push_back(std::move(job));
    ask.cursor = std::move(page.cursor);
  } while (!ask.cursor.empty());
  if (jobs.empty()) {
    throw rpc::RefusedError({.kind = rpc::RefusalKind::not_found,
                             .sentence = fmt::format("There is no group g{}.", group),
                             .what_to_do = "To list jobs and groups, run `sleight list`."});
  }
  return jobs;
}

std::vector<rpc::JobView> views_of(rpc::Client& client, std::span<const JobName> names,
                                   bool with_history) {
  std::vector<rpc::JobView> views;
  std::set<rpc::JobId> seen;
  const auto add = [&](rpc::JobView view) {
    if (!seen.insert(view.id).second) return;
    if (!with_history) view.history.clear();
    views.push_back(std::move(view));
  };
  for (const JobName& name : names) {
    if (const auto* job = std::get_if<rpc::JobId>(&name)) {
      add(client.status(*job));
    } else if (const auto* range = std::get_if<JobRange>(&name)) {
      for_each_job(*range, [&](rpc::JobId id) { add(client.status(id)); });
    } else {
      for (rpc::JobView& view : jobs_of(client, std::get<rpc::GroupId>(name)))
        add(with_history ? client.status(view.id) : std::move(view));
    }
  }
  return views;
}

TouchedJobs change(rpc::Client& client, std::span<const JobName> names, rpc::ChangeAsk ask) {
  TouchedJobs touched;
  const auto add = [&](rpc::Target target, const std::string& name, bool is_of_range) {
    try {
      ask.target = target;
      for (rpc::Touched& one : client.change(ask))
        touched.done.push_back(std::move(one));
    } catch (const rpc::RefusedError& refused) {
      const bool is_left_out = is_of_range && is_absence(refused.refusal());
      if (is_single_job(names) || is_left_out) throw;
      touched.refused.push_back({.name = name, .refusal = refused.refusal()});
    }
  };
  for (const JobName& name : names) {
    if (const auto* job = std::get_if<rpc::JobId>(&name)) {
      add(rpc::Target::of(*job), fmt::format("{}", *job), false);
    } else if (const auto* range = std::get_if<JobRange>(&name)) {
      for_each_job(*range,
                   [&](rpc::JobId id) { add(rpc::Target::of(id), fmt::format("{}", id), true); });
    } else {
      const auto group = std::get<rpc::GroupId>(name);
      add(rpc::Target::of(group), fmt::format("g{}", group), false);
    }
  }
  return touched;
}

}  // namespace sleight::service_client
