#include "common/events/run_end.h"

#include <algorithm>
#include <array>
#include <utility>

#include "common/base/check.h"
#include "common/json/value.h"

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

std::string line_of(const RunEnd& end) {
  const json::Value json{{"epoch", end.epoch},
                         {"end", name_of(end.end)},
                         {"exit_code", static_cast<int>(end.exit_code)},
                         {"scans", end.scans},
                         {"found", end.found},
                         {"solutions", end.solutions},
                         {"digest", end.digest},
                         {"words", end.words},
                         {"place", end.place}};
  // Bytes that are no UTF-8 (a file's name) become U+FFFD.
  return json.dump() + "\n";
}

/// The first and the last `half` bytes.
std::string without_middle(const std::string& words, std::size_t half) {
  if (words.size() <= 2 * half) return words;
  return words.substr(0, half) + std::string(k_left_out) + words.substr(words.size() - half);
}

}  // namespace

std::string_view name_of(End end) {
  for (const auto& [known, name] : k_names) {
    if (known == end) return name;
  }
  base::check_failed("a known end", "");
}

RunEnd end_by(const std::exception& error) {
  const auto* known = dynamic_cast<const base::Error*>(&error);
  return {.end = End::failed,
          .exit_code = known != nullptr ? known->exit_code() : base::ExitCode::bug,
          .words = error.what()};
}

std::string to_line(const RunEnd& end) {
  std::string line = line_of(end);
  // A character may take six bytes in JSON, so that the words are cut until they fit.
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
  const auto json = json::Value::parse_or_null(line);
  if (!json.is_object() || json.size() != 9) return std::nullopt;
  const auto number = [&](const char* key) -> std::optional<std::uint64_t> {
    const auto* found = json.find(key);
    if (!found || !found->is_whole()) return std::nullopt;
    return found->get<std::uint64_t>();
  };
  const auto text = [&](const char* key) -> std::optional<std::string> {
    const auto* found = json.find(key);
    if (!found || !found->is_string()) return std::nullopt;
    return found->get<std::string>();
  };
  const auto epoch = number("epoch");
  const auto code = number("exit_code");
  const auto scans = number("scans");
  const auto found = number("found");
  const auto solutions = number("solutions");
  auto digest = text("digest");
  auto words = text("words");
  auto place = text("place");
  const auto name = text("end");
  if (!epoch || !code || !scans || !found || !solutions || !digest || !words || !place || !name)
    return std::nullopt;
  const auto end = std::find_if(k_names.begin(), k_names.end(),
                                [&](const auto& k) { return k.second == *name; });
  const auto exit_code = std::find_if(k_exit_codes.begin(), k_exit_codes.end(), [&](auto k) {
    return static_cast<std::uint64_t>(k) == *code;
  });
  if (end == k_names.end() || exit_code == k_exit_codes.end()) return std::nullopt;
  return RunEnd{.epoch = *epoch,
                .end = end->first,
                .exit_code = *exit_code,
                .scans = *scans,
                .found = *found,
                .solutions = *solutions,
                .digest = *std::move(digest),
                .words = *std::move(words),
                .place = *std::move(place)};
}

}  // namespace sleight::events
