// The program `sleight-keeper`. The keeper itself is keep.h.
#include "service/keeper/main_keeper.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>

#include "common/base/check.h"
#include "common/base/error.h"
#include "common/base/version.h"
#include "service/keeper/keep.h"

namespace sleight::programs {
namespace {

/// If the caller closed standard streams, opens them, so that no file of the keeper gets their
/// numbers.
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
  app.add_option("--folder", options.folder, "Job folder, also the program's working folder")
      ->required()
      ->check(CLI::ExistingDirectory)
      ->type_name("FOLDER");
  app.add_option("--attempt", options.attempt, "Number of this attempt (1 for the first)")
      ->required()
      ->check(CLI::PositiveNumber)
      ->type_name("N");
  app.add_flag("--ranks", options.with_ranks,
               "The program is mpirun. Kill mpirun if no rank starts, or if mpirun still runs "
               "after all ranks exit");
  app.add_flag("--batch", options.in_batch,
               "Run inside a batch system's job, where SIGTERM also stops the program cleanly");
  app.add_option("--grace", options.grace_s,
                 "Kill the program if it is still running this long after it reported its end. "
                 "Default: 30")
      ->check(CLI::NonNegativeNumber)
      ->type_name("SECONDS");
  app.add_option("program", options.command, "Program to run and its arguments, after --")
      ->required()
      ->type_name("PROGRAM ARGUMENTS...");
  app.footer(
      "The server starts sleight-keeper for each attempt of a job; see docs/OPERATING.md.\nSIGUSR1 "
      "and Ctrl-C stop the program cleanly. SIGTERM kills the program and everything it "
      "started.\n\nExit codes: 0 the attempt has ended, and attempt.json has its result; 2 invalid "
      "command line;\n4 another keeper uses the folder, or the attempt has already begun; 5 the "
      "folder can't be written;\n1 a bug.");
}

}  // namespace

int keeper_main(int argc, char** argv, keeper::Moments& moments) {
  occupy_streams();
  base::report_uncaught_exceptions();
  base::add_repeat_note(base::command_line(argc, argv));
  CLI::App app{"Run one attempt of a job: start its program and record how it ended."};
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
    // keep() changes the working folder.
    options.folder = std::filesystem::absolute(options.folder).string();
    return static_cast<int>(keeper::keep(options, moments));
  } catch (const base::Error& error) {
    fmt::print(stderr, "sleight-keeper: {}\n", error.what());
    return static_cast<int>(error.exit_code());
  }
}

}  // namespace sleight::programs
