#include "clients/cli/service_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace sleight::cli {
namespace {

Json time_json(double time_s) {
  return time_s > 0 ? Json(time_s) : Json(nullptr);
}

template <class T>
Json optional_json(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json group_json(const std::optional<rpc::GroupId>& group) {
  return group ? Json(fmt::format("g{}", *group)) : Json(nullptr);
}

Json failures_json(std::span<const rpc::FailureCount> failures) {
  std::uint64_t total = 0;
  for (const rpc::FailureCount& failure : failures)
    total += failure.count;
  Json json{{"total", total}};
  for (const rpc::FailureCount& failure : failures)
    json[failure.simulation] = failure.count;
  return json;
}

Json list_or_one(Json list, bool is_single) {
  return is_single && list.size() == 1 ? Json(list[0]) : list;
}

}  // namespace

Json to_json(const rpc::StateChange& change) {
  return {{"change", change.number},
          {"time", time_json(change.time_s)},
          {"state", rpc::name_of(change.state)},
          {"reason", change.reason},
          {"start", change.attempt}};
}

Json to_json(const rpc::JobView& job, bool with_history) {
  Json json{{"id", job.id.value},
            {"group", group_json(job.group)},
            {"user", job.user},
            {"name", job.name},
            {"world", job.world},
            {"state", rpc::name_of(job.state)},
            {"reason", job.reason},
            {"place", job.place > 0 ? Json(job.place) : Json(nullptr)},
            {"not_yet", job.not_yet},
            {"starts", job.attempt},
            {"priority", job.priority},
            {"cores_wanted", optional_json(job.cores_wanted)},
            {"cores", job.cores},
            {"ranks", job.ranks},
            {"memory_bytes", job.memory_bytes},
            {"strict", job.strict},
            {"pinned", job.pinned},
            {"scans_done", job.scans_done},
            {"scans_total", job.scans_total > 0 ? Json(job.scans_total) : Json(nullptr)},
            {"found", job.solutions.found},
            {"found_wanted", job.solutions.found_wanted},
            {"in_proportion", job.solutions.in_proportion},
            {"in_proportion_wanted", job.solutions.in_proportion_wanted},
            {"failed_simulations", failures_json(job.failures)},
            {"simulations_per_second", job.simulations_per_s},
            {"left_seconds", optional_json(job.left_s)},
            {"solutions_left_seconds", optional_json(job.solutions_left_s)},
            {"core_seconds", job.core_s},
            {"submitted", time_json(job.submitted_s)},
            {"started", time_json(job.started_s)},
            {"ended", time_json(job.ended_s)},
            {"bytes", job.bytes},
            {"deleted_at", time_json(job.deleted_at_s)},
            {"digest", job.digest},
            {"results_version", job.results_version},
            {"end_words", job.end_words},
            {"last_log_lines", job.last_log_lines},
            {"repeat_command", job.repeat_command}};
  if (with_history) {
    json["history"] = Json::array();
    for (const rpc::StateChange& change : job.history)
      json["history"].push_back(to_json(change));
  }
  return json;
}

Json to_json(const rpc::Touched& touched) {
  return {
      {"id", touched.job.value}, {"state", rpc::name_of(touched.state)}, {"words", touched.words}};
}

Json to_json(const rpc::Submitted& submitted) {
  Json ids = Json::array();
  for (const rpc::JobId job : submitted.jobs)
    ids.push_back(job.value);
  Json id = submitted.group ? group_json(submitted.group) : ids.empty() ? Json(nullptr) : ids[0];
  return {{"id", std::move(id)}, {"group", group_json(submitted.group)}, {"ids", std::move(ids)}};
}

namespace {

/// "core-hours of a user" as a key: core_hours_of_a_user.
std::string key_of(std::string words) {
  std::ranges::replace_if(
      words, [](char c) { return c == ' ' || c == '-' || c == ','; }, '_');
  return words;
}

}  // namespace

Json to_json(const rpc::ServerView& server) {
  Json limits = Json::object();
  for (const rpc::NamedLimit& limit : server.limits)
    limits[key_of(limit.name)] = limit.value;
  Json jobs = Json::object();
  for (const rpc::StateCount& count : server.counts)
    jobs[std::string(rpc::name_of(count.state))] = count.count;
  return {{"pid", server.pid},
          {"version", server.version},
          {"results_version", server.results_version},
          {"state_folder", server.state_folder},
          {"up_seconds", server.up_s},
          {"draining", server.draining},
          {"backend", server.backend},
          {"cores", server.cores},
          {"cores_used", server.cores_used},
          {"memory_bytes", server.memory_bytes},
          {"memory_used_bytes", server.memory_used_bytes},
          {"disk_free_bytes", server.disk_free_bytes},
          {"disk_reserve_bytes", server.disk_reserve_bytes},
          {"keeping_rule", server.keeping_rule},
          {"limits", std::move(limits)},
          {"jobs", std::move(jobs)},
          {"connections", server.connections},
          {"watchers", server.watchers},
          {"address", server.address.empty() ? Json(nullptr) : Json(server.address)},
          {"fingerprint", server.fingerprint.empty() ? Json(nullptr) : Json(server.fingerprint)}};
}

Json to_json(const rpc::LogPiece& piece) {
  return {
      {"first", piece.first}, {"end", piece.end}, {"over", piece.is_over}, {"text", piece.text}};
}

Json jobs_json(std::span<const rpc::JobView> jobs, bool is_single, bool with_history) {
  Json list = Json::array();
  for (const rpc::JobView& job : jobs)
    list.push_back(to_json(job, with_history));
  return list_or_one(std::move(list), is_single);
}

Json touched_json(std::span<const rpc::Touched> touched, bool is_single) {
  Json list = Json::array();
  for (const rpc::Touched& one : touched)
    list.push_back(to_json(one));
  return list_or_one(std::move(list), is_single);
}

Json event_json(rpc::JobId job, const std::string& line) {
  const Json event = Json::parse_or_null(line);
  if (!event.is_object()) return nullptr;
  Json json{{"job", job.value}};
  // `job` is ours to say, whatever a later event has under that name.
  for (const auto& [key, value] : event.items()) {
    if (key != "job") json[key] = value;
  }
  return json;
}

Json change_json(rpc::JobId job, const rpc::StateChange& change) {
  Json json{{"job", job.value}, {"number", 0}, {"kind", "state"}};
  json.update(to_json(change));
  return json;
}

std::string on_one_line(const Json& json) {
  return json.dump(-1, true);
}

std::string indented(const Json& json) {
  return json.dump(2, true);
}

}  // namespace sleight::cli
