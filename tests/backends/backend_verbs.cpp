// Runs any backend for the conformance suite, with the messages of service/backend/messages.h.
//   - `sleight-backend --kind slurm --script direct.sbatch [--option KEY=VALUE] VERB` uses Slurm.
//   - `sleight-backend --kind program --program PATH [--seconds S] VERB` uses a program.
// The program reads the question on stdin. Each run of the program acts like a new daemon.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/json/value.h"
#include "service/backend/messages.h"
#include "service/backend/program_backend.h"
#include "service/backend/slurm_backend.h"

namespace sleight::backend {
namespace {

struct Arguments {
  std::string kind;
  std::string verb;
  std::vector<std::string> options;
  SlurmSettings slurm;
  ProgramSettings program;
};

std::unique_ptr<Backend> backend_of(Arguments arguments, const base::Clock& clock) {
  for (const std::string& option : arguments.options) {
    const std::size_t sign = option.find('=');
    arguments.slurm.defaults[option.substr(0, sign)] = option.substr(sign + 1);
  }
  if (arguments.kind == "slurm") return std::make_unique<SlurmBackend>(arguments.slurm, clock);
  return std::make_unique<ProgramBackend>(arguments.program);
}

[[noreturn]] void refuse(const std::string& words) {
  throw base::Error(base::ExitCode::usage, words);
}

AttemptName name_in(const json::Value& json) {
  const AttemptName name{.daemon = json.at("daemon").text(),
                         .job = json.at("job").get<std::uint64_t>(),
                         .epoch = json.at("epoch").get<std::uint64_t>()};
  if (!is_daemon_name(name.daemon) || name.job == 0 || name.epoch == 0)
    refuse("'attempt' has no daemon, job and epoch of the stated forms");
  return name;
}

Order order_in(const json::Value& json) {
  Order order{.name = name_in(json.at("attempt")),
              .folder = json.at("folder").text(),
              .command = json.at("command").get<std::vector<std::string>>(),
              .label = json.value("label", ""),
              .cores = json.value("cores", std::uint32_t{1}),
              .ranks = json.value("ranks", std::uint32_t{0}),
              .memory_bytes = json.value("memory_bytes", std::uint64_t{0}),
              .options = json.value("options", std::map<std::string, std::string>())};
  check_order(order);
  return order;
}

void put(json::Value& json, const Seen& seen) {
  json["state"] = name_of(seen.state);
  json["id"] = seen.id;
  json["words"] = seen.words;
  json["cause"] = name_of(seen.cause);
}

/// Answers a question. Throws the backend's errors, and json::Error if the question is invalid.
std::string answer_to(std::string_view verb, std::string_view text, Backend& backend) {
  const json::Value question = json::Value::parse(text);
  if (question.at("version") != k_message_version) refuse("the question is of another version");
  json::Value answer{{"version", k_message_version}};
  if (verb == "launch") {
    put(answer, backend.launch(order_in(question)));
  } else if (verb == "state") {
    put(answer, backend.state(name_in(question.at("attempt"))));
  } else if (verb == "signal") {
    const std::string how = question.value("how", "in_order");
    if (how != "in_order" && how != "now") refuse("'how' is none that is known");
    answer["signalled"] = backend.signal(name_in(question.at("attempt")),
                                         how == "now" ? keeper::Stop::now : keeper::Stop::in_order);
  } else if (verb == "list") {
    const std::string daemon = question.at("daemon").text();
    if (!is_daemon_name(daemon)) refuse("'daemon' is of another form");
    answer["attempts"] = json::Value::array();
    for (const auto& [name, seen] : backend.list(daemon)) {
      json::Value entry;
      entry["attempt"] = {{"daemon", name.daemon}, {"job", name.job}, {"epoch", name.epoch}};
      put(entry, seen);
      answer["attempts"].push_back(std::move(entry));
    }
  } else if (verb == "log") {
    const std::size_t bytes_max = question.value("bytes_max", k_log_bytes_most);
    answer["log"] = backend.log(name_in(question.at("attempt")), question.value("folder", ""),
                                std::min(bytes_max, k_log_bytes_most));
  } else {
    refuse("the verb is none of launch, state, signal, list, log");
  }
  return answer.dump() + "\n";
}

int main_of(int argc, char** argv) {
  CLI::App app{"A backend as a program"};
  Arguments arguments;
  app.add_option("--kind", arguments.kind)->required()->check(CLI::IsMember({"slurm", "program"}));
  app.add_option("--script", arguments.slurm.script);
  app.add_option("--option", arguments.options);
  app.add_option("--program", arguments.program.program);
  app.add_option("--seconds", arguments.program.answer_s_max);
  app.add_option("verb", arguments.verb)->required();
  CLI11_PARSE(app, argc, argv);
  try {
    const base::SteadyClock clock;
    const std::string question(std::istreambuf_iterator<char>(std::cin), {});
    const auto backend = backend_of(arguments, clock);
    fmt::print("{}", answer_to(arguments.verb, question, *backend));
    return 0;
  } catch (const Away& away) {
    fmt::print(stderr, "sleight-backend: {}\n", away.what());
    return k_exit_away;
  } catch (const base::Error& error) {
    fmt::print(stderr, "sleight-backend: {}\n", error.what());
    return static_cast<int>(error.exit_code());
  } catch (const json::Error& error) {
    fmt::print(stderr, "sleight-backend: {}\n", error.what());
    return static_cast<int>(base::ExitCode::usage);
  }
}

}  // namespace
}  // namespace sleight::backend

int main(int argc, char** argv) {
  return sleight::backend::main_of(argc, argv);
}
