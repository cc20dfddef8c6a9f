#include "common/events/run_end.h"

#include <array>
#include <utility>

#include "common/base/check.h"
#include "common/json/fields.h"

namespace sleight::events {
namespace {

constexpr std::array<std::pair<End, std::string_view>, 8> k_names{
    {{End::finished, "finished"},
     {End::gave_up, "gave_up"},
     {End::no_draws, "no_draws"},
     {End::time_limit, "time_limit"},
     {End::stop_requested, "stop_requested"},
     {End::simulation_failed, "simulation_failed"},
     {End::failed, "failed"},
     {End::bug, "bug"}}};
constexpr std::array k_exit_codes{base::ExitCode::ok,          base::ExitCode::bug,
                                  base::ExitCode::usage,       base::ExitCode::bad_request,
                                  base::ExitCode::conflict,    base::ExitCode::environment,
                                  base::ExitCode::bad_archive, base::ExitCode::not_mixed,
                                  base::ExitCode::interrupted, base::ExitCode::simulation_failed};
constexpr std::string_view k_left_out = " [...] ";

std::optional<End> end_of(const std::string& name) {
  for (const auto& [end, known] : k_names)
    if (known == name) return end;
  return std::nullopt;
}

std::optional<base::ExitCode> exit_code_of(int code) {
  for (const base::ExitCode known : k_exit_codes)
    if (static_cast<int>(known) == code) return known;
  return std::nullopt;
}

template <class Visit, class Record>
void end_fields(Visit& visit, Record& end) {
  visit("epoch", end.epoch);
  visit.as(
      "end", end.end, [](End known) { return name_of(known); }, end_of);
  visit.as(
      "exit_code", end.exit_code, [](base::ExitCode code) { return static_cast<int>(code); },
      exit_code_of);
  visit("scans", end.scans);
  visit("found", end.found);
  visit("solutions", end.solutions);
  visit("digest", end.digest);
  visit("words", end.words);
  visit("place", end.place);
}

std::string line_of(const RunEnd& end) {
  json::Value json;
  json::FieldWriter writer(json, json::None::null);
  end_fields(writer, end);
  // Replace invalid UTF-8 by U+FFFD. A file's name may contain invalid UTF-8.
  return json.dump() + "\n";
}

std::string without_middle(const std::string& words, std::size_t half) {
  if (words.size() <= 2 * half) return words;
  return words.substr(0, half) + std::string(k_left_out) + words.substr(words.size() - half);
}

}  // namespace

std::string_view name_of(End end) {
  for (const auto& [known, name] : k_names) {
    if (known == end) return name;
  }
  base::check_failed("the end is known", "");
}

RunEnd end_by(const std::exception& error) {
  const auto* known = dynamic_cast<const base::Error*>(&error);
  return {.end = End::failed,
          .exit_code = known != nullptr ? known->exit_code() : base::ExitCode::bug,
          .words = error.what()};
}

std::string to_line(const RunEnd& end) {
  std::string line = line_of(end);
  // A character may take six bytes in JSON, so shorten the message until the line fits.
  RunEnd shorter = end;
  for (std::size_t half = k_end_line_bytes_max / 2; line.size() > k_end_line_bytes_max; half /= 2) {
    shorter.words = without_middle(end.words, half);
    shorter.place = without_middle(end.place, half);
    shorter.digest = without_middle(end.digest, half);
    line = line_of(shorter);
  }
  return line;
}

std::optional<RunEnd> run_end_of(std::string_view line) {
  try {
    const json::Value json = json::Value::parse(line);
    RunEnd end;
    json::FieldReader reader(json, json::None::null);
    end_fields(reader, end);
    return json.size() == 9 ? std::optional(std::move(end)) : std::nullopt;
  } catch (const json::Error&) {
    return std::nullopt;
  }
}

}  // namespace sleight::events
