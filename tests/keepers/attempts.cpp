// Runs commands of the local backend, and prints their results as JSON. Each run of the program
// acts like a new daemon.
//   `sleight-attempts launch FOLDER N [options]` prints the keeper's process id.
//   `sleight-attempts look FOLDER N` prints the attempt's state, record and message.
//   `sleight-attempts stop FOLDER N in_order|now` prints whether there was an attempt to stop.
//   `sleight-attempts await FOLDER N` waits until the keeper exits, then prints what `look` prints.
#include <fmt/format.h>
#include <poll.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <string>

#include "common/base/error.h"
#include "common/json/value.h"
#include "service/keeper/backend.h"

namespace sleight::keeper {
namespace {

using Json = json::Value;

struct Arguments {
  std::string bin;
  std::string keeper;   ///< replaces the one in `bin`
  std::string sleight;  ///< replaces the one in `bin`
  std::string how;
  AttemptSpec spec;
};

std::string name_of(Look::State state) {
  switch (state) {
    case Look::State::never_began:
      return "never_began";
    case Look::State::running:
      return "running";
    case Look::State::ended:
      return "ended";
    case Look::State::died:
      return "died";
  }
  return "";
}

Json json_of(const Look& look) {
  return {{"state", name_of(look.state)},
          {"record", look.record ? Json::parse(to_text(*look.record)) : Json()},
          {"words", look.words}};
}

Programs programs_of(const Arguments& arguments) {
  Programs programs = programs_beside_this();
  programs.keeper = arguments.keeper.empty() ? arguments.bin + "/sleight-keeper" : arguments.keeper;
  programs.sleight = arguments.sleight.empty() ? arguments.bin + "/sleight" : arguments.sleight;
  programs.sleight_batch = arguments.bin + "/sleight-batch";
  return programs;
}

/// Waits until the attempt has begun or the keeper has exited.
void await_begin(const LocalBackend& backend, const RunningKeeper& keeper,
                 const std::string& folder, std::uint32_t attempt) {
  while (!keeper.has_gone() && backend.look(folder, attempt).state == Look::State::never_began)
    ::poll(nullptr, 0, 1);
}

/// Waits for an attempt's end, as a restarted daemon does.
Look await_end(const LocalBackend& backend, const std::string& folder, std::uint32_t attempt) {
  while (true) {
    const Look look = backend.look(folder, attempt);
    if (look.state != Look::State::running) return look;
    if (const auto keeper = backend.adopt(folder, attempt)) {
      pollfd wait{.fd = keeper->descriptor(), .events = POLLIN, .revents = 0};
      ::poll(&wait, 1, -1);
    } else {
      ::poll(nullptr, 0, 5);  // the keeper has no record yet, or is just exiting
    }
  }
}

Json run(const CLI::App& app, const Arguments& arguments) {
  const LocalBackend backend(programs_of(arguments));
  const std::string& folder = arguments.spec.folder;
  const std::uint32_t attempt = arguments.spec.attempt;
  if (app.got_subcommand("launch")) {
    const RunningKeeper keeper = backend.launch(arguments.spec);
    await_begin(backend, keeper, folder, attempt);
    return {{"pid", keeper.identity().pid}};
  }
  if (app.got_subcommand("stop")) {
    const Stop how = arguments.how == "now" ? Stop::now : Stop::in_order;
    return {{"stopped", backend.stop(folder, attempt, how)}};
  }
  if (app.got_subcommand("await")) return json_of(await_end(backend, folder, attempt));
  return json_of(backend.look(folder, attempt));
}

int main_of(int argc, char** argv) {
  CLI::App app{"The local backend as commands"};
  Arguments arguments;
  app.require_subcommand(1);
  app.add_option("--bin", arguments.bin)->required();
  app.add_option("--keeper", arguments.keeper);
  app.add_option("--sleight", arguments.sleight);
  for (const char* name : {"launch", "look", "stop", "await"}) {
    CLI::App* command = app.add_subcommand(name);
    command->add_option("folder", arguments.spec.folder)->required();
    command->add_option("attempt", arguments.spec.attempt)->required();
    if (std::string_view(name) == "stop") command->add_option("how", arguments.how)->required();
    if (std::string_view(name) != "launch") continue;
    command->add_option("-j", arguments.spec.cores);
    command->add_option("--ranks", arguments.spec.ranks);
    command->add_flag("--strict", arguments.spec.strict);
    command->add_option("--grace", arguments.spec.grace_s);
  }
  CLI11_PARSE(app, argc, argv);
  try {
    fmt::print("{}\n", run(app, arguments).dump());
    return 0;
  } catch (const base::Error& error) {
    fmt::print(stderr, "sleight-attempts: {}\n", error.what());
    return static_cast<int>(error.exit_code());
  }
}

}  // namespace
}  // namespace sleight::keeper

int main(int argc, char** argv) {
  return sleight::keeper::main_of(argc, argv);
}
