#include "service/keeper/attempt_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>
#include <system_error>
#include <utility>

#include "common/base/bytes.h"
#include "common/base/check.h"
#include "common/base/error.h"
#include "common/json/value.h"

namespace sleight::keeper {
namespace {

using Json = json::Value;

constexpr int k_format = 1;
constexpr const char* k_begin_beside = "attempt.json.new";
constexpr const char* k_end_beside = "attempt.json.end";
constexpr std::size_t k_word_bytes_max = 256;

constexpr std::array<std::pair<Stop, std::string_view>, 2> k_stops{
    {{Stop::in_order, "in_order"}, {Stop::now, "now"}}};
constexpr std::array<std::pair<KilledFor, std::string_view>, 4> k_kills{
    {{KilledFor::nothing, ""},
     {KilledFor::asked, "asked"},
     {KilledFor::lingering, "lingering"},
     {KilledFor::without_ranks, "without_ranks"}}};

template <class T, std::size_t n>
std::string_view name_in(const std::array<std::pair<T, std::string_view>, n>& names, T value) {
  for (const auto& [known, name] : names) {
    if (known == value) return name;
  }
  base::check_failed("a known value", "");
}

template <class T, std::size_t n>
std::optional<T> value_in(const std::array<std::pair<T, std::string_view>, n>& names,
                          const std::string& name) {
  for (const auto& [value, known] : names) {
    if (known == name) return value;
  }
  return std::nullopt;
}

Json json_of(const AttemptEnd& end) {
  Json json;
  json["exit_code"] = end.exit_code ? Json(*end.exit_code) : Json();
  json["signal"] = end.signal ? Json(*end.signal) : Json();
  json["not_started"] = end.not_started;
  json["killed_for"] = name_in(k_kills, end.killed_for);
  json["stop_asked"] = end.stop_asked ? Json(name_in(k_stops, *end.stop_asked)) : Json();
  // As its own line, which knows its own keys and bounds.
  json["run_end"] = end.run_end ? Json(events::to_line(*end.run_end)) : Json();
  json["wall_s"] = end.wall_s;
  json["processor_s"] = end.processor_s;
  json["memory_bytes_max"] = end.memory_bytes_max;
  json["ended_unix_s"] = end.ended_unix_s;
  json["log_tail"] = end.log_tail;
  return json;
}

std::string text_of(const AttemptRecord& record) {
  Json json;
  json["format"] = k_format;
  json["attempt"] = record.attempt;
  json["keeper"] = {{"pid", record.keeper.pid},
                    {"start_ticks", record.keeper.start_ticks},
                    {"boot", record.keeper.boot}};
  json["command"] = record.command;
  json["begun_unix_s"] = record.begun_unix_s;
  json["epoch_before"] = record.epoch_before;
  json["end"] = record.end ? json_of(*record.end) : Json();
  // Bytes that are no UTF-8 become U+FFFD.
  return json.dump() + "\n";
}

void shorten(std::string& word) {
  if (word.size() <= k_word_bytes_max) return;
  constexpr std::size_t half = k_word_bytes_max / 2 - 4;
  word = word.substr(0, half) + " [...] " + word.substr(word.size() - half);
}

/// A field of an object; the json's own exceptions say that it is missing or of another type.
template <class T>
T field(const Json& json, const char* key) {
  return json.at(key).get<T>();
}

template <class T>
std::optional<T> optional_field(const Json& json, const char* key) {
  if (json.at(key).is_null()) return std::nullopt;
  return field<T>(json, key);
}

AttemptEnd end_of(const Json& json) {
  AttemptEnd end{.exit_code = optional_field<int>(json, "exit_code"),
                 .signal = optional_field<int>(json, "signal"),
                 .not_started = field<std::string>(json, "not_started"),
                 .wall_s = field<double>(json, "wall_s"),
                 .processor_s = field<double>(json, "processor_s"),
                 .memory_bytes_max = field<std::uint64_t>(json, "memory_bytes_max"),
                 .ended_unix_s = field<double>(json, "ended_unix_s"),
                 .log_tail = field<std::vector<std::string>>(json, "log_tail")};
  // value() of none throws, as a missing field does.
  end.killed_for = value_in(k_kills, field<std::string>(json, "killed_for")).value();
  if (const auto stop = optional_field<std::string>(json, "stop_asked"))
    end.stop_asked = value_in(k_stops, *stop).value();
  if (const auto line = optional_field<std::string>(json, "run_end"))
    end.run_end = events::run_end_of(*line).value();
  return end;
}

AttemptRecord record_of_json(const Json& json) {
  const Json& keeper = json.at("keeper");
  AttemptRecord record{.attempt = field<std::uint32_t>(json, "attempt"),
                       .keeper = {.pid = field<pid_t>(keeper, "pid"),
                                  .start_ticks = field<std::uint64_t>(keeper, "start_ticks"),
                                  .boot = field<std::string>(keeper, "boot")},
                       .command = field<std::vector<std::string>>(json, "command"),
                       .begun_unix_s = field<double>(json, "begun_unix_s"),
                       .epoch_before = field<std::uint64_t>(json, "epoch_before")};
  if (!json.at("end").is_null()) record.end = end_of(json.at("end"));
  return record;
}

[[noreturn]] void fail_at(const std::string& path, const std::error_code& reason) {
  throw base::Error(fmt::format("{}: {}", path, reason.message()));
}

base::BytesView bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text));
}

}  // namespace

std::string to_text(const AttemptRecord& record) {
  std::string text = text_of(record);
  AttemptRecord shorter = record;
  while (text.size() > k_record_bytes_max && shorter.end && !shorter.end->log_tail.empty()) {
    auto& tail = shorter.end->log_tail;
    tail.erase(tail.begin(), tail.begin() + static_cast<std::ptrdiff_t>((tail.size() + 1) / 2));
    text = text_of(shorter);
  }
  if (text.size() > k_record_bytes_max) {
    if (shorter.end) shorten(shorter.end->not_started);
    for (std::string& word : shorter.command)
      shorten(word);
    shorter.command.resize(std::min<std::size_t>(shorter.command.size(), 30));
    text = text_of(shorter);
  }
  CHECK_LE(text.size(), k_record_bytes_max);
  return text;
}

std::optional<AttemptRecord> record_of(std::string_view text) {
  try {
    const Json json = Json::parse(text);
    if (field<int>(json, "format") != k_format) return std::nullopt;
    return record_of_json(json);
  } catch (const json::Error&) {
    return std::nullopt;
  } catch (const std::bad_optional_access&) {
    return std::nullopt;
  }
}

std::string record_text_in(const std::string& folder) {
  const std::string path = folder + "/" + k_record_name;
  return base::PosixFileSystem().exists(path) ? base::read_text_file(path, k_record_bytes_max)
                                              : std::string();
}

std::optional<AttemptRecord> record_in(const std::string& folder, const std::string& text) {
  if (text.empty()) return std::nullopt;
  auto record = record_of(text);
  if (!record) {
    throw base::Error(fmt::format(
        "{}/{}: not a record of an attempt, or of another version of Sleight; what ran in this "
        "folder is not known: move the file away if nothing runs there",
        folder, k_record_name));
  }
  return record;
}

std::optional<AttemptRecord> read_record(const std::string& folder) {
  return record_in(folder, record_text_in(folder));
}

RecordFile::RecordFile(base::FileSystem& files, std::string folder)
    : files_(files), folder_(std::move(folder)) {}

void RecordFile::begin(const AttemptRecord& record) {
  // Room for the end comes first: where the disk has none, the program does not start.
  const std::string end_path = path(k_end_beside);
  auto room = files_.create(end_path);
  if (!room) fail_at(end_path, room.error());
  room_ = std::move(room).value();
  const std::vector<std::byte> zeros(k_record_bytes_max);
  if (const auto error = room_->write_at(0, zeros)) fail_at(end_path, error);
  files_.sync_file(end_path);

  const std::string beside = path(k_begin_beside);
  auto file = files_.create(beside);
  if (!file) fail_at(beside, file.error());
  if (const auto error = file.value()->write_at(0, bytes_of(to_text(record))))
    fail_at(beside, error);
  if (const auto error = std::move(file).value()->close()) fail_at(beside, error);
  put(k_begin_beside);
}

void RecordFile::end(const AttemptRecord& record) {
  CHECK(record.end.has_value());
  CHECK(room_ != nullptr);
  const std::string text = to_text(record);
  const std::string beside = path(k_end_beside);
  if (const auto error = room_->write_at(0, bytes_of(text))) fail_at(beside, error);
  if (const auto error = room_->resize(text.size())) fail_at(beside, error);
  if (const auto error = room_->close()) fail_at(beside, error);
  put(k_end_beside);
}

void RecordFile::put(const std::string& beside) {
  files_.sync_file(path(beside.c_str()));
  files_.rename(path(beside.c_str()), path(k_record_name));
  files_.sync_directory_of(path(k_record_name));
}

}  // namespace sleight::keeper
