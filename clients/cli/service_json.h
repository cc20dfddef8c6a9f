// The service's answers as JSON for scripts. docs/SERVICE.md ("JSON") specifies the fields; new
// versions only add fields.
//
// Ids are numbers. A group is a text such as "g5", which commands accept. Times are seconds since
// 1970; null: unknown or not yet. Pure; thread-safe.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "common/json/value.h"
#include "common/rpc/client.h"
#include "common/rpc/service.h"

namespace sleight::cli {

using Json = json::Value;

/// Returns null for 0.
Json time_json(double time_s);
Json group_json(const std::optional<rpc::GroupId>& group);
/// Returns, for example, {"total": 3, "search_gave_up": 3}.
Json failures_json(std::span<const rpc::FailureCount> failures);
template <class T>
Json optional_json(const std::optional<T>& value) {
  return value ? Json(*value) : Json();
}

/// Returns everything about a job (job_text.h). `with_history`: includes its changes.
Json to_json(const rpc::JobView& job, bool with_history);
Json to_json(const rpc::StateChange& change);
Json to_json(const rpc::Touched& touched);
/// The key `id` has a value that other commands accept: 17, or "g5" for a group.
Json to_json(const rpc::Submitted& submitted);
Json to_json(const rpc::LogPiece& piece);

/// Return an object if a single job was named, otherwise a list.
Json jobs_json(std::span<const rpc::JobView> jobs, bool is_single, bool with_history = false);
Json touched_json(std::span<const rpc::Touched> touched, bool is_single);

/// Returns the object of run_event.h with `job` added. Null if the line isn't an object.
Json event_json(rpc::JobId job, const std::string& line);
/// Returns, for example, {"job":17,"kind":"state","change":3,"state":"running",...}.
Json change_json(rpc::JobId job, const rpc::StateChange& change);

/// Return ASCII text with other characters as \u00e9, so that nothing affects a terminal.
std::string on_one_line(const Json& json);
std::string indented(const Json& json);

}  // namespace sleight::cli
