// The program `sleight`: parses the command line and calls its action.
#include <CLI/CLI.hpp>

#include "clients/cli/main_app.h"
#include "clients/cli/main_run.h"
#include "clients/terminal/output.h"
#include "common/base/error.h"
#include "common/logging/log.h"

namespace sleight::programs {
namespace {

int main_of(int argc, char** argv) {
  CommandLine line;
  CLI::App app;
  build_app(app, line);
  note_what_repeats(argc, argv);
  try {
    terminal::occupy_standard_streams();
    return terminal::with_results([&] {
      try {
        app.parse(argc, argv);
      } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : static_cast<int>(base::ExitCode::usage);
      }
      logging::log_to_stderr("sleight", line.verbose);
      return line.action();
    });
  } catch (...) {
    return report_failure("sleight");
  }
}

}  // namespace
}  // namespace sleight::programs

int main(int argc, char** argv) {
  return sleight::programs::main_of(argc, argv);
}
