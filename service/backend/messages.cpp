#include "service/backend/messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "common/json/value.h"

namespace sleight::backend {
namespace {

using Json = json::Value;

[[noreturn]] void refuse_message(const std::string& words) {
  throw base::Error(base::ExitCode::usage, words);
}

std::string text_of(const Json& json) {
  // Bytes that are no UTF-8 become U+FFFD.
  return json.dump() + "\n";
}

Json message() {
  return Json{{"version", k_message_version}};
}

Json parsed(std::string_view text) {
  const Json json = Json::parse_or_null(text);
  if (!json.is_object()) refuse_message("the message is no JSON object");
  const auto* version = json.find("version");
  if (!version || *version != k_message_version)
    refuse_message(fmt::format("the message's version is not {}", k_message_version));
  return json;
}

/// The value of a key, or what it is where it is left out. Throws where it is of another type.
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
  if (!fits) refuse_message(fmt::format("the message's '{}' is of another type", key));
  return found->template get<T>();
}

Json json_of(const AttemptName& name) {
  return {{"daemon", name.daemon}, {"job", name.job}, {"epoch", name.epoch}};
}

AttemptName name_in(const Json& json) {
  const auto* found = json.find("attempt");
  if (!found || !found->is_object()) refuse_message("the message has no 'attempt'");
  AttemptName name{.daemon = value_of<std::string>(*found, "daemon", ""),
                   .job = value_of<std::uint64_t>(*found, "job", 0),
                   .epoch = value_of<std::uint64_t>(*found, "epoch", 0)};
  if (!is_daemon_name(name.daemon) || name.job == 0 || name.epoch == 0)
    refuse_message("the message's 'attempt' has no daemon, job and epoch of the stated forms");
  return name;
}

void put(Json& json, const Seen& seen) {
  json["state"] = name_of(seen.state);
  json["id"] = seen.id;
  json["words"] = seen.words;
  json["cause"] = name_of(seen.cause);
}

Seen seen_in(const Json& json) {
  const auto state = state_of(value_of<std::string>(json, "state", ""));
  const auto cause = cause_of(value_of<std::string>(json, "cause", "itself"));
  if (!state) refuse_message("the message's 'state' is none that is known");
  return {.state = *state,
          .id = value_of<std::string>(json, "id", ""),
          .words = value_of<std::string>(json, "words", ""),
          // One that later versions add says nothing here.
          .cause = cause.value_or(Cause::itself)};
}

Order order_in(const Json& json) {
  Order order{.name = name_in(json),
              .folder = value_of<std::string>(json, "folder", ""),
              .label = value_of<std::string>(json, "label", ""),
              .cores = value_of<std::uint32_t>(json, "cores", 1),
              .ranks = value_of<std::uint32_t>(json, "ranks", 0),
              .memory_bytes = value_of<std::uint64_t>(json, "memory_bytes", 0)};
  const Json command = json.value("command", Json::array());
  if (!command.is_array()) refuse_message("the message's 'command' is no array");
  for (const Json& word : command.elements()) {
    if (!word.is_string()) refuse_message("the message's 'command' is no array of texts");
    order.command.push_back(word.get<std::string>());
  }
  const Json options = json.value("options", Json::object());
  if (!options.is_object()) refuse_message("the message's 'options' is no object");
  for (const auto& [key, value] : options.items()) {
    if (!value.is_string()) refuse_message(fmt::format("the option '{}' is no text", key));
    order.options[key] = value.get<std::string>();
  }
  check_order(order);
  return order;
}

}  // namespace

std::string text_of_question(std::string_view verb, const Question& question) {
  const Order& order = question.order;
  Json json = message();
  if (verb == "list") {
    json["daemon"] = order.name.daemon;
    return text_of(json);
  }
  json["attempt"] = json_of(order.name);
  if (verb == "launch") {
    json["folder"] = order.folder;
    json["command"] = order.command;
    json["label"] = order.label;
    json["cores"] = order.cores;
    json["ranks"] = order.ranks;
    json["memory_bytes"] = order.memory_bytes;
    json["options"] = Json::object();
    for (const auto& [key, value] : order.options)
      json["options"][key] = value;
  } else if (verb == "signal") {
    json["how"] = question.how == keeper::Stop::now ? "now" : "in_order";
  } else if (verb == "log") {
    json["folder"] = order.folder;
    json["bytes_max"] = question.bytes_max;
  }
  return text_of(json);
}

Question question_of(std::string_view verb, std::string_view text) {
  const Json json = parsed(text);
  Question question;
  if (verb == "launch") {
    question.order = order_in(json);
  } else if (verb == "list") {
    question.order.name.daemon = value_of<std::string>(json, "daemon", "");
    if (!is_daemon_name(question.order.name.daemon))
      refuse_message("the message's 'daemon' is of another form");
  } else if (verb == "state" || verb == "signal" || verb == "log") {
    question.order.name = name_in(json);
    question.order.folder = value_of<std::string>(json, "folder", "");
    question.bytes_max = std::min<std::size_t>(
        value_of<std::uint64_t>(json, "bytes_max", k_log_bytes_most), k_log_bytes_most);
    const auto how = value_of<std::string>(json, "how", "in_order");
    if (how != "in_order" && how != "now") refuse_message("the message's 'how' is none known");
    question.how = how == "now" ? keeper::Stop::now : keeper::Stop::in_order;
  } else {
    refuse_message(fmt::format("'{}' is no verb: launch, state, signal, list, log", verb));
  }
  return question;
}

std::string text_of_seen(const Seen& seen) {
  Json json = message();
  put(json, seen);
  return text_of(json);
}

Seen seen_of(std::string_view text) {
  return seen_in(parsed(text));
}

std::string text_of_signalled(bool is_there) {
  Json json = message();
  json["signalled"] = is_there;
  return text_of(json);
}

bool signalled_of(std::string_view text) {
  return value_of<bool>(parsed(text), "signalled", false);
}

std::string text_of_list(const std::map<AttemptName, Seen>& listed) {
  Json json = message();
  json["attempts"] = Json::array();
  for (const auto& [name, seen] : listed) {
    Json entry{{"attempt", json_of(name)}};
    put(entry, seen);
    json["attempts"].push_back(std::move(entry));
  }
  return text_of(json);
}

std::map<AttemptName, Seen> list_of(const std::string& daemon, std::string_view text) {
  const Json json = parsed(text);
  const auto* attempts = json.find("attempts");
  if (!attempts || !attempts->is_array()) refuse_message("the message has no 'attempts'");
  std::map<AttemptName, Seen> listed;
  for (const Json& entry : attempts->elements()) {
    if (!entry.is_object()) refuse_message("an entry of the message's 'attempts' is no object");
    const AttemptName name = name_in(entry);
    if (name.daemon == daemon) listed.insert_or_assign(name, seen_in(entry));
  }
  return listed;
}

std::string text_of_log(std::string_view log) {
  Json json = message();
  json["log"] = log;
  return text_of(json);
}

std::string log_of(std::string_view text, std::size_t bytes_max) {
  auto log = value_of<std::string>(parsed(text), "log", "");
  if (log.size() > bytes_max) log.erase(0, log.size() - bytes_max);
  return log;
}

std::string answer_to(std::string_view verb, std::string_view text, Backend& backend) {
  const Question question = question_of(verb, text);
  const Order& order = question.order;
  if (verb == "launch") return text_of_seen(backend.launch(order));
  if (verb == "state") return text_of_seen(backend.state(order.name));
  if (verb == "signal") return text_of_signalled(backend.signal(order.name, question.how));
  if (verb == "list") return text_of_list(backend.list(order.name.daemon));
  return text_of_log(backend.log(order.name, order.folder, question.bytes_max));
}

}  // namespace sleight::backend
