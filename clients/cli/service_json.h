// The service's answers as JSON for scripts. docs/SERVICE.md ("JSON") specifies the fields; new
// versions only add fields.
//
// Ids are numbers; a group is "g5", as commands take it. Times are seconds since 1970; null: not
// yet, or not known. Pure; thread-safe.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "common/json/value.h"
#include "common/rpc/client.h"
#include "common/rpc/service.h"

namespace sleight::cli {

using Json = json::Value;

/// Seconds since 1970, or null of 0.
Json time_json(double time_s);
Json group_json(const std::optional<rpc::GroupId>& group);
/// {"total": 3, "search_gave_up": 3}
Json failures_json(std::span<const rpc::FailureCount> failures);
template <class T>
Json optional_json(const std::optional<T>& value) {
  return value ? Json(*value) : Json();
}

/// All of a job (job_text.h), and its changes.
Json to_json(const rpc::JobView& job, bool with_history);
Json to_json(const rpc::StateChange& change);
Json to_json(const rpc::Touched& touched);
/// `id` is what other commands take: 17, or "g5" of a group.
Json to_json(const rpc::Submitted& submitted);
Json to_json(const rpc::LogPiece& piece);

/// One object of one job that was named alone, else a list.
Json jobs_json(std::span<const rpc::JobView> jobs, bool is_single, bool with_history = false);
Json touched_json(std::span<const rpc::Touched> touched, bool is_single);

/// An event of a job: run_event.h's object with `job` before it. Null where the line is no object.
Json event_json(rpc::JobId job, const std::string& line);
/// {"job": 17, "kind": "state", "change": 3, "state": "running", ...}.
Json change_json(rpc::JobId job, const rpc::StateChange& change);

/// In ASCII, other characters as \u00e9: nothing in it steers a terminal.
std::string on_one_line(const Json& json);
std::string indented(const Json& json);

}  // namespace sleight::cli
