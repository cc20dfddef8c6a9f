// The program `sleight-keeper`. The keeper itself is keep.h.
#include "service/keeper/main_keeper.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>

#include "common/base/check.h"
#include "common/base/error.h"
#include "common/base/version.h"
#include "service/keeper/keep.h"

namespace sleight::programs {
namespace {

/// Those that the caller closed: no file of the keeper's takes their place.
void occupy_streams() {
  while (true) {
    const int descriptor = ::open("/dev/null", O_RDWR);
    if (descriptor < 0 || descriptor > STDERR_FILENO) {
      if (descriptor >= 0) ::close(descriptor);
      return;
    }
  }
}

void add_options(CLI::App& app, keeper::KeeperOptions& options) {
  app.add_option("--folder", options.folder, "The job's folder, and the program's working folder")
      ->required()
      ->check(CLI::ExistingDirectory)
      ->type_name("FOLDER");
  app.add_option("--attempt", options.attempt, "Which start of the job's program this is, from 1")
      ->required()
      ->check(CLI::PositiveNumber)
      ->type_name("N");
  app.add_flag("--ranks", options.with_ranks, "The program is mpirun, and is watched as such");
  app.add_flag("--batch", options.in_batch,
               "A batch system's job holds it: SIGTERM ends the program in order too");
  app.add_option("--grace", options.grace_s,
                 "How long it may linger once it has told its end (30 if not given)")
      ->check(CLI::NonNegativeNumber)
      ->type_name("SECONDS");
  app.add_option("program", options.command, "The program and its arguments, after --")
      ->required()
      ->type_name("PROGRAM ARGUMENTS...");
  app.footer(
      "The service starts it for each attempt of a job (docs/OPERATING.md).\n"
      "SIGUSR1 and Ctrl-C end the program in order, SIGTERM kills it and all that it started.\n\n"
      "Exit codes: 0 the attempt has ended, however it did: attempt.json says how; 2 the command "
      "line\n"
      "can't be understood; 4 another keeper has the folder, or the attempt has begun before;\n"
      "5 the folder can't be written; 1 a bug.");
}

}  // namespace

int keeper_main(int argc, char** argv, keeper::Moments& moments) {
  occupy_streams();
  base::report_uncaught_exceptions();
  base::add_repeat_note(base::command_line(argc, argv));
  CLI::App app{"Runs one attempt of a job: starts its program, and writes down how it ended."};
  app.name("sleight-keeper");
  app.set_version_flag("--version", fmt::format("sleight-keeper {}", base::version()));
  keeper::KeeperOptions options;
  add_options(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(base::ExitCode::usage);
  }
  try {
    // The working folder changes.
    options.folder = std::filesystem::absolute(options.folder).string();
    return static_cast<int>(keeper::keep(options, moments));
  } catch (const base::Error& error) {
    fmt::print(stderr, "sleight-keeper: {}\n", error.what());
    return static_cast<int>(error.exit_code());
  }
}

}  // namespace sleight::programs
