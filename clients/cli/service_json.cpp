#include "clients/cli/service_json.h"

#include <fmt/format.h>

#include "clients/cli/job_text.h"

namespace sleight::cli {

namespace {

Json list_or_one(Json list, bool is_single) {
  return is_single && list.size() == 1 ? Json(list[0]) : list;
}

}  // namespace

Json time_json(double time_s) {
  return time_s > 0 ? Json(time_s) : Json();
}

Json group_json(const std::optional<rpc::GroupId>& group) {
  return group ? Json(fmt::format("g{}", *group)) : Json();
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

Json to_json(const rpc::StateChange& change) {
  return {{"change", change.number},
          {"time", time_json(change.time_s)},
          {"state", rpc::name_of(change.state)},
          {"reason", change.reason},
          {"start", change.attempt}};
}

Json to_json(const rpc::JobView& job, bool with_history) {
  Json json = job_report(job).as_json();
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
  // Keep our own `job`, even if a future event has a key `job`.
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
