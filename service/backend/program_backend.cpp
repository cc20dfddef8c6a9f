#include "service/backend/program_backend.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "service/keeper/command.h"
#include "service/keeper/tool.h"

namespace sleight::backend {
namespace {

/// Treats an invalid answer like no answer. The program's next version may give a valid answer.
template <class Read>
auto read_or_away(std::string_view verb, const Read& read) {
  try {
    return read();
  } catch (const base::Error& failure) {
    throw Away(fmt::format("{}: invalid answer: {}", verb, failure.what()), verb == "launch");
  }
}

}  // namespace

ProgramBackend::ProgramBackend(ProgramSettings settings) : settings_(std::move(settings)) {}

std::string ProgramBackend::title() const {
  return std::filesystem::path(settings_.program).filename().string();
}

std::string ProgramBackend::ask(std::string_view verb, const Question& question) const {
  const bool is_launch = verb == "launch";
  keeper::ToolEnd end;
  try {
    end = keeper::run_tool({settings_.program, std::string(verb)},
                           {.input = text_of_question(verb, question),
                            .seconds_max = settings_.answer_s_max,
                            .output_bytes_max = k_message_bytes_max,
                            .environment = keeper::whole_environment(),
                            .stop = &is_ending_});
  } catch (const base::Error& failure) {
    throw Away(failure.what());
  }
  const std::string words = fmt::format("{} {}: {}", title(), verb, end.why());
  if (end.exit_code < 0 || end.exit_code == k_exit_away) throw Away(words, is_launch);
  if (end.exit_code != 0) throw base::Error(words);
  if (end.is_cut)
    throw Away(fmt::format("{} {}: the output is too long", title(), verb), is_launch);
  return std::move(end.output);
}

Seen ProgramBackend::launch(const Order& order) {
  check_order(order);
  const std::string answer = ask("launch", {.order = order});
  return read_or_away("launch", [&] { return seen_of(answer); });
}

Seen ProgramBackend::state(const AttemptName& name) {
  const std::string answer = ask("state", {.order = {.name = name}});
  return read_or_away("state", [&] { return seen_of(answer); });
}

bool ProgramBackend::signal(const AttemptName& name, keeper::Stop how) {
  const std::string answer = ask("signal", {.order = {.name = name}, .how = how});
  return read_or_away("signal", [&] { return signalled_of(answer); });
}

std::map<AttemptName, Seen> ProgramBackend::list(const std::string& daemon) {
  const std::string answer = ask("list", {.order = {.name = {.daemon = daemon}}});
  return read_or_away("list", [&] { return list_of(daemon, answer); });
}

std::string ProgramBackend::log(const AttemptName& name, const std::string& folder,
                                std::size_t bytes_max) {
  const std::string answer =
      ask("log", {.order = {.name = name, .folder = folder}, .bytes_max = bytes_max});
  return read_or_away("log", [&] { return log_of(answer, bytes_max); });
}

}  // namespace sleight::backend
