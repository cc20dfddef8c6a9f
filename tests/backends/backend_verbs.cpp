// Any backend as a program of the stated interface (service/backend/messages.h), for the
// conformance suite:
//   sleight-backend --kind slurm --script direct.sbatch [--option KEY=VALUE] VERB
//   sleight-backend --kind program --program PATH [--seconds S] VERB
// It reads the question on stdin. Each call is a daemon of its own, which is gone when it returns.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "common/base/clock.h"
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
  }
}

}  // namespace
}  // namespace sleight::backend

int main(int argc, char** argv) {
  return sleight::backend::main_of(argc, argv);
}
