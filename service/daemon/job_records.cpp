#include "service/daemon/job_records.h"

#include "common/json/fields.h"

namespace sleight::daemon {
namespace {

constexpr auto k_name_of = [](auto value) { return jobs::name_of(value); };

template <class Visit, class Wishes>
void wishes_fields(Visit& visit, Wishes& wishes) {
  visit("cores", wishes.cores);
  visit("ranks", wishes.ranks);
  visit("memory_bytes", wishes.memory_bytes);
}

template <class Visit, class Counts>
void counts_fields(Visit& visit, Counts& counts) {
  visit("scans", counts.scans);
  visit("found", counts.found);
  visit("solutions", counts.solutions);
  visit("failures", counts.failures);
}

// Each list of fields is used for both writing and reading, so that writer and reader can't differ.

template <class Visit, class Job>
void job_fields(Visit& visit, Job& job) {
  visit("id", job.id);
  visit("user", job.user);
  visit("client_key", job.client_key);
  visit("content", job.content);
  visit("name", job.name);
  visit("group", job.group);
  visit("priority", job.priority);
  visit.part("wishes", job.wishes, [](auto& v, auto& part) { wishes_fields(v, part); });
  visit("pinned", job.pinned);
  visit("revision", job.revision);
  visit("is_leaving", job.is_leaving);
  visit.as("state", job.state, k_name_of, jobs::state_of);
  visit.as("reason", job.reason, k_name_of, jobs::reason_of);
  visit("words", job.words);
  visit("attempt", job.attempt);
  visit("attempt_revision", job.attempt_revision);
  visit("cores", job.cores);
  visit("attempt_begin_s", job.attempt_begin_s);
  visit.part("counts", job.counts, [](auto& v, auto& part) { counts_fields(v, part); });
  visit("scans_at_attempt", job.scans_at_attempt);
  visit("results_version", job.results_version);
  visit("deaths", job.deaths);
  visit("scans_at_death", job.scans_at_death);
  visit("back_offs", job.back_offs);
  visit("bug_place", job.bug_place);
  visit("scans_at_bug", job.scans_at_bug);
  visit("fruitless", job.fruitless);
  visit("next_start_s", job.next_start_s);
  visit("start_cost_s", job.start_cost_s);
  visit("stop_cost_s", job.stop_cost_s);
  visit("core_seconds", job.core_seconds);
  visit("disk_bytes", job.disk_bytes);
  visit.as("end", job.end, k_name_of, jobs::end_kind_of);
  visit("digest", job.digest);
  visit("queued_since_s", job.queued_since_s);
  visit("over_since_s", job.over_since_s);
  visit("remove_at_s", job.remove_at_s);
  visit("submitted_wall", job.submitted_wall);
  visit("began_wall", job.began_wall);
  visit("over_wall", job.over_wall);
  visit("changed_wall", job.changed_wall);
  visit("next_start_wall", job.next_start_wall);
  visit("remove_wall", job.remove_wall);
}

template <class Visit, class Change>
void change_fields(Visit& visit, Change& change) {
  visit("id", change.id);
  visit.as("from", change.from, k_name_of, jobs::state_of);
  visit.as("to", change.to, k_name_of, jobs::state_of);
  visit.as("reason", change.reason, k_name_of, jobs::reason_of);
  visit("attempt", change.attempt);
  visit("wall", change.wall);
  visit("words", change.words);
}

template <class Visit, class Usage>
void usage_fields(Visit& visit, Usage& usage) {
  visit("user", usage.user);
  visit("at_s", usage.at_s);
  visit("share_core_s", usage.share_core_s);
  visit("allowance_core_s", usage.allowance_core_s);
}

template <class Value, class Fields>
std::string line_of(const Value& value, const Fields& fields) {
  json::Value json = json::Value::object();
  json::FieldWriter writer(json, json::None::left_out);
  fields(writer, value);
  // A program's messages may contain any bytes.
  return json.dump();
}

template <class Value, class Fields>
std::optional<Value> value_of(std::string_view line, const Fields& fields) {
  try {
    const json::Value json = json::Value::parse(line);
    Value value{};
    json::FieldReader reader(json, json::None::left_out);
    fields(reader, value);
    return value;
  } catch (const json::Error&) {
    return std::nullopt;
  }
}

constexpr auto k_job = [](auto& visit, auto& job) { job_fields(visit, job); };
constexpr auto k_change = [](auto& visit, auto& change) { change_fields(visit, change); };
constexpr auto k_usage = [](auto& visit, auto& usage) { usage_fields(visit, usage); };

}  // namespace

std::string to_line(const jobs::Job& job) {
  return line_of(job, k_job);
}
std::string to_line(const jobs::Change& change) {
  return line_of(change, k_change);
}
std::string to_line(const jobs::Usage& usage) {
  return line_of(usage, k_usage);
}

std::optional<jobs::Job> job_of(std::string_view line) {
  return value_of<jobs::Job>(line, k_job);
}
std::optional<jobs::Change> change_of(std::string_view line) {
  return value_of<jobs::Change>(line, k_change);
}
std::optional<jobs::Usage> usage_of(std::string_view line) {
  return value_of<jobs::Usage>(line, k_usage);
}

}  // namespace sleight::daemon
