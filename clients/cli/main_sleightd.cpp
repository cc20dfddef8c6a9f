// The daemon `sleightd`: connects the service to the worlds, which check requests.
#include <fmt/format.h>
#include <grp.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "clients/cli/main_run.h"
#include "clients/cli/main_settings.h"
#include "clients/cli/main_worlds.h"
#include "clients/cli/results_version.h"
#include "clients/service_client/server_process.h"
#include "clients/terminal/output.h"
#include "common/access/server_address.h"
#include "common/base/clock.h"
#include "common/base/error.h"
#include "common/base/file_system.h"
#include "common/base/version.h"
#include "common/config/quantities.h"
#include "common/config/settings.h"
#include "common/logging/log.h"
#include "common/request/direction_request.h"
#include "common/request/text.h"
#include "service/backend/backend.h"
#include "service/backend/program_backend.h"
#include "service/backend/slurm_backend.h"
#include "service/backend/slurm_options.h"
#include "service/daemon/daemon.h"
#include "service/keeper/command.h"

namespace sleight::programs {
namespace {

struct System {
  std::shared_ptr<backend::Backend> backend{};  ///< null: this machine
  std::string name{};                           ///< "local", "slurm", or the program's path
  std::string script{};                         ///< path of direct.sbatch for slurm
};

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

/// Returns the system that the settings select. Throws base::Error(usage) that names an invalid
/// setting.
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

/// Throws base::Error(usage) if the system doesn't support a job's options.
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

std::string limit_text(const std::optional<std::uint64_t>& limit, const char* unit) {
  return limit ? fmt::format("{}{}", *limit, unit) : "none";
}

daemon::ServerFacts facts_of(const config::Settings& settings) {
  const config::UserLimits& limits = settings.limits;
  return {.version = std::string(base::version()),
          .results_version = std::string(results_version()),
          .cache_mb = settings.cache_mb.value,
          .keeping_rule = fmt::format(
              "finished jobs are deleted after {} days; if they take more than {}, the oldest are "
              "deleted earlier; pinned jobs are never deleted",
              settings.keep_days.value, config::bytes_text(settings.keep_bytes.value)),
          .limits = {{.name = "jobs of a user", .value = limit_text(limits.jobs.value, "")},
                     {.name = "cores of a user", .value = limit_text(limits.cores.value, "")},
                     {.name = "core-hours of a user in a day",
                      .value = limit_text(limits.core_hours.value, "")},
                     {.name = "bytes of a user",
                      .value = limits.bytes.value ? config::bytes_text(*limits.bytes.value)
                                                  : std::string("none")},
                     {.name = "states of a job", .value = limit_text(limits.states.value, "")},
                     {.name = "simulations of a job",
                      .value = limit_text(limits.simulations.value, "")}},
          .request_limits = {.states = limits.states.value.value_or(0),
                             .simulations = limits.simulations.value.value_or(0)},
          .job_cores = static_cast<std::uint32_t>(settings.job_cores.value),
          .check_options =
              [settings](const std::map<std::string, std::string>& given) {
                check_options(settings, given);
              },
          .backend = settings.backend.value};
}

jobs::Options job_options_of(const config::Settings& settings) {
  constexpr double k_day_s = 86400;
  jobs::Options options;
  options.limits = {
      .jobs = settings.limits.jobs.value.value_or(0),
      .cores = static_cast<std::uint32_t>(settings.limits.cores.value.value_or(0)),
      .core_hours_per_day = static_cast<double>(settings.limits.core_hours.value.value_or(0)),
      .disk_bytes = settings.limits.bytes.value.value_or(0)};
  options.slice_s_min = settings.slice_s.value;
  options.keep_s = static_cast<double>(settings.keep_days.value) * k_day_s;
  options.keep_bytes = settings.keep_bytes.value;
  return options;
}

/// Returns the group's number. Throws base::Error if there is no such group.
std::optional<std::uint32_t> group_of(const config::Setting<std::string>& setting) {
  if (setting.value.empty()) return std::nullopt;
  const group* found = ::getgrnam(setting.value.c_str());
  if (found != nullptr) return found->gr_gid;
  throw base::Error(base::ExitCode::usage,
                    fmt::format("{}: no group {} on this machine", setting.given_by,
                                request::printable(setting.value, 60)));
}

int serve(const config::Settings& settings) {
  if (::geteuid() == 0 && !settings.allow_root.value) {
    throw base::Error(base::ExitCode::not_allowed,
                      "refusing to run as root, because every job would run as root; use a "
                      "separate user, or --allow-root on a machine that serves nothing else");
  }
  const run::Catalogue catalogue = worlds_of_program();
  const System system = system_of(settings);
  // Compute these before the options: GCC 12 destroys an aggregate's members twice if a later
  // initialiser throws.
  const std::optional<std::uint32_t> group = group_of(settings.group);
  daemon::ServerFacts facts = facts_of(settings);
  daemon::DaemonOptions options{
      .runner = {.state = settings.state.value,
                 .jobs = job_options_of(settings),
                 .cores = static_cast<std::uint32_t>(settings.cores.value),
                 .memory_bytes = settings.memory_bytes.value,
                 .disk_reserve_bytes = settings.disk_reserve_bytes.value,
                 .programs = keeper::programs_beside_this(),
                 .system = system.backend},
      .socket = settings.socket.value,
      .group = group,
      .address = settings.listen.value.empty() ? std::nullopt
                                               : access::server_address_of(settings.listen.value),
      .certificate_path = settings.tls_certificate.value,
      .key_path = settings.tls_key.value,
      .facts = std::move(facts),
      .read = [&](const std::string& text, const std::string& name) {
        return request::read_request(text, name, catalogue.bindings());
      }};
  daemon::run_daemon(options);
  return static_cast<int>(base::ExitCode::ok);
}

int main_of(int argc, char** argv) {
  note_what_repeats(argc, argv);
  CLI::App app;
  std::vector<config::Given> given;
  build_daemon_app(app, given);
  try {
    terminal::occupy_standard_streams();
    try {
      app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      return app.exit(error) == 0 ? 0 : static_cast<int>(base::ExitCode::usage);
    }
    logging::log_to_stderr("sleightd", false);
    return serve(config::settings_here(given));
  } catch (...) {
    return report_failure("sleightd");
  }
}

}  // namespace
}  // namespace sleight::programs

int main(int argc, char** argv) {
  return sleight::programs::main_of(argc, argv);
}
