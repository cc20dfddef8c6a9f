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
#include "common/json/fields.h"

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
  base::check_failed("the value has a name", "");
}

template <class T, std::size_t n>
std::optional<T> value_in(const std::array<std::pair<T, std::string_view>, n>& names,
                          const std::string& name) {
  for (const auto& [value, known] : names) {
    if (known == name) return value;
  }
  return std::nullopt;
}

// Each list of fields is used for both reading and writing.

template <class Visit, class Keeper>
void keeper_fields(Visit& visit, Keeper& keeper) {
  visit("pid", keeper.pid);
  visit("start_ticks", keeper.start_ticks);
  visit("boot", keeper.boot);
}

template <class Visit, class End>
void end_fields(Visit& visit, End& end) {
  visit("exit_code", end.exit_code);
  visit("signal", end.signal);
  visit("not_started", end.not_started);
  visit.as(
      "killed_for", end.killed_for, [](KilledFor why) { return name_in(k_kills, why); },
      [](const std::string& name) { return value_in(k_kills, name); });
  visit.as(
      "stop_asked", end.stop_asked, [](Stop how) { return name_in(k_stops, how); },
      [](const std::string& name) { return value_in(k_stops, name); });
  // A run's end is stored as a line of run_end.h. The line's reader checks keys and limits.
  visit.as(
      "run_end", end.run_end, [](const events::RunEnd& ended) { return events::to_line(ended); },
      events::run_end_of);
  visit("wall_s", end.wall_s);
  visit("processor_s", end.processor_s);
  visit("memory_bytes_max", end.memory_bytes_max);
  visit("ended_unix_s", end.ended_unix_s);
  visit("log_tail", end.log_tail);
}

template <class Visit, class Record>
void record_fields(Visit& visit, Record& record) {
  visit("attempt", record.attempt);
  visit.part("keeper", record.keeper, [](auto& v, auto& part) { keeper_fields(v, part); });
  visit("command", record.command);
  visit("begun_unix_s", record.begun_unix_s);
  visit("epoch_before", record.epoch_before);
  visit.part("end", record.end, [](auto& v, auto& part) { end_fields(v, part); });
}

std::string text_of(const AttemptRecord& record) {
  Json json{{"format", k_format}};
  json::FieldWriter writer(json, json::None::null);
  record_fields(writer, record);
  // Invalid UTF-8 becomes U+FFFD.
  return json.dump() + "\n";
}

void shorten(std::string& word) {
  if (word.size() <= k_word_bytes_max) return;
  constexpr std::size_t half = k_word_bytes_max / 2 - 4;
  word = word.substr(0, half) + " [...] " + word.substr(word.size() - half);
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
    if (json.at("format").get<int>() != k_format) return std::nullopt;
    AttemptRecord record;
    json::FieldReader reader(json, json::None::null);
    record_fields(reader, record);
    return record;
  } catch (const json::Error&) {
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
    throw base::Error(
        fmt::format("{}/{}: the file is not an attempt record of this Sleight version; move it "
                    "away if no program runs in the folder",
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
  // Reserve room for the end first. If the disk is full, the program then doesn't start.
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
