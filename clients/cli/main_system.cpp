#include "clients/cli/main_system.h"

#include <fmt/format.h>
#include <unistd.h>

#include "clients/service_client/server_process.h"
#include "common/base/clock.h"
#include "common/base/error.h"
#include "common/base/file_system.h"
#include "common/request/text.h"
#include "service/backend/program_backend.h"
#include "service/backend/slurm_backend.h"
#include "service/backend/slurm_options.h"

namespace sleight::programs {
namespace {

backend::Options defaults_of(const config::SlurmDefaults& slurm) {
  backend::Options options;
  const auto add = [&](const char* name, const config::Setting<std::string>& setting) {
    if (!setting.value.empty()) options[name] = setting.value;
  };
  add("account", slurm.account);
  add("partition", slurm.partition);
  add("qos", slurm.qos);
  add("time", slurm.time);
  add("more", slurm.more);
  return options;
}

/// Returns the given script. If none is given, returns the script installed with this program.
std::string script_of(const config::Settings& settings) {
  if (!settings.slurm.script.value.empty()) return settings.slurm.script.value;
  const std::string bin = base::directory_of(service_client::program_beside("sleight-keeper"));
  return base::directory_of(bin) + "/share/sleight/slurm/direct.sbatch";
}

}  // namespace

System system_of(const config::Settings& settings) {
  static const base::SteadyClock clock;
  const std::string& name = settings.backend.value;
  if (name == "local") return {.backend = nullptr, .name = name};
  if (name == "slurm") {
    const std::string script = script_of(settings);
    if (::access(script.c_str(), R_OK) != 0) {
      throw base::Error(
          base::ExitCode::usage,
          fmt::format("slurm.script: can't read {}; expected a copy of deploy/slurm/direct.sbatch",
                      request::printable(script, 200)));
    }
    return {.backend = std::make_shared<backend::SlurmBackend>(
                backend::SlurmSettings{.script = script, .defaults = defaults_of(settings.slurm)},
                clock),
            .name = name,
            .script = script};
  }
  if (::access(name.c_str(), X_OK) != 0) {
    throw base::Error(base::ExitCode::usage,
                      fmt::format("{}: {} is not a program that can be run",
                                  settings.backend.given_by, request::printable(name, 200)));
  }
  return {.backend =
              std::make_shared<backend::ProgramBackend>(backend::ProgramSettings{.program = name}),
          .name = name};
}

void check_options(const config::Settings& settings,
                   const std::map<std::string, std::string>& options) {
  if (options.empty()) return;
  if (settings.backend.value == "local") {
    throw base::Error(base::ExitCode::usage,
                      "This service runs jobs on its own machine and accepts no job options.");
  }
  if (settings.backend.value == "slurm")
    static_cast<void>(backend::slurm_wishes_of(defaults_of(settings.slurm), options));
}

}  // namespace sleight::programs
