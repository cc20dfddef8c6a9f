#include "service/backend/messages.h"

#include <fmt/format.h>

#include "common/json/value.h"

namespace sleight::backend {
namespace {

using Json = json::Value;

[[noreturn]] void refuse_message(const std::string& words) {
  throw base::Error(base::ExitCode::usage, words);
}

Json parsed(std::string_view text) {
  const Json json = Json::parse_or_null(text);
  if (!json.is_object()) refuse_message("the message is not a JSON object");
  const auto* version = json.find("version");
  if (!version || *version != k_message_version)
    refuse_message(fmt::format("expected message version {}", k_message_version));
  return json;
}

/// Returns the key's value, or `otherwise` if the key is missing. Throws if the type is wrong.
template <class T>
T value_of(const Json& json, const char* key, T otherwise) {
  const auto* found = json.find(key);
  if (!found || found->is_null()) return otherwise;
  bool fits = false;
  if constexpr (std::is_same_v<T, std::string>) {
    fits = found->is_string();
  } else if constexpr (std::is_same_v<T, bool>) {
    fits = found->is_boolean();
  } else {
    fits = found->is_whole();
  }
  if (!fits) refuse_message(fmt::format("'{}' in the message has the wrong type", key));
  return found->template get<T>();
}

AttemptName name_in(const Json& json) {
  const auto* found = json.find("attempt");
  if (!found || !found->is_object()) refuse_message("the message lacks the object 'attempt'");
  AttemptName name{.daemon = value_of<std::string>(*found, "daemon", ""),
                   .job = value_of<std::uint64_t>(*found, "job", 0),
                   .epoch = value_of<std::uint64_t>(*found, "epoch", 0)};
  if (!is_daemon_name(name.daemon) || name.job == 0 || name.epoch == 0)
    refuse_message("'attempt' in the message lacks a valid daemon, job or epoch");
  return name;
}

Seen seen_in(const Json& json) {
  const auto state = state_of(value_of<std::string>(json, "state", ""));
  const auto cause = cause_of(value_of<std::string>(json, "cause", "itself"));
  if (!state) refuse_message("the message has an unknown 'state'");
  return {.state = *state,
          .id = value_of<std::string>(json, "id", ""),
          .words = value_of<std::string>(json, "words", ""),
          // Ignore a cause that a later version added.
          .cause = cause.value_or(Cause::itself)};
}

}  // namespace

std::string text_of_question(std::string_view verb, const Question& question) {
  const Order& order = question.order;
  Json json{{"version", k_message_version}};
  if (verb == "list") {
    json["daemon"] = order.name.daemon;
    return json.dump() + "\n";
  }
  json["attempt"] = {
      {"daemon", order.name.daemon}, {"job", order.name.job}, {"epoch", order.name.epoch}};
  if (verb == "launch") {
    json["folder"] = order.folder;
    json["command"] = order.command;
    json["label"] = order.label;
    json["cores"] = order.cores;
    json["ranks"] = order.ranks;
    json["memory_bytes"] = order.memory_bytes;
    json["options"] = order.options;
  } else if (verb == "signal") {
    json["how"] = question.how == keeper::Stop::now ? "now" : "in_order";
  } else if (verb == "log") {
    json["folder"] = order.folder;
    json["bytes_max"] = question.bytes_max;
  }
  // Invalid UTF-8 becomes U+FFFD.
  return json.dump() + "\n";
}

Seen seen_of(std::string_view text) {
  return seen_in(parsed(text));
}

bool signalled_of(std::string_view text) {
  return value_of<bool>(parsed(text), "signalled", false);
}

std::map<AttemptName, Seen> list_of(const std::string& daemon, std::string_view text) {
  const Json json = parsed(text);
  const auto* attempts = json.find("attempts");
  if (!attempts || !attempts->is_array()) refuse_message("the message lacks the array 'attempts'");
  std::map<AttemptName, Seen> listed;
  for (const Json& entry : attempts->elements()) {
    if (!entry.is_object())
      refuse_message("'attempts' in the message has an entry that is not an object");
    const AttemptName name = name_in(entry);
    if (name.daemon == daemon) listed.insert_or_assign(name, seen_in(entry));
  }
  return listed;
}

std::string log_of(std::string_view text, std::size_t bytes_max) {
  auto log = value_of<std::string>(parsed(text), "log", "");
  if (log.size() > bytes_max) log.erase(0, log.size() - bytes_max);
  return log;
}

}  // namespace sleight::backend
