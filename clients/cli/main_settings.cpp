#include "clients/cli/main_settings.h"

#include <string>

#include "clients/cli/main_run.h"

namespace sleight::programs {
namespace {

/// A setting that has a command-line option. Other settings can be set only in the settings file.
struct SettingOption {
  const char* key;
  const char* option;
  const char* type;  ///< null: a flag
  const char* help;
};

static_assert(config::k_disk_reserve_bytes == 1'000'000'000 && config::k_slice_s == 10 &&
                  config::k_keep_days == 30 && config::k_keep_bytes == 50'000'000'000 &&
                  config::k_cache_mb == 256 && config::k_system_cores == 1024 &&
                  config::k_system_memory_bytes == 4'000'000'000'000,
              "the help quotes these values");

constexpr SettingOption k_options[] = {
    {"state", "--state", "FOLDER",
     "Folder for jobs, archives and the log. Default: ~/.local/state/sleight"},
    {"socket", "--socket", "PATH",
     "Path of the service's Unix socket. Default: socket in the state folder"},
    {"group", "--group", "NAME",
     "Unix group whose members may use the service, in addition to the service's own user. "
     "Default: none"},
    {"listen", "--listen", "ADDRESS",
     "Address for access from other machines, over TLS, for example 0.0.0.0:7423. "
     "Default: none"},
    {"tls_certificate", "--tls-certificate", "FILE",
     "TLS certificate (absolute path, PEM). Default: self-signed"},
    {"tls_key", "--tls-key", "FILE", "Private key of the TLS certificate (absolute path, PEM)"},
    {"backend", "--backend", "NAME",
     "System that runs jobs: local (this machine), slurm, or a program's absolute path. Default: "
     "local"},
    {"allow_root", "--allow-root", nullptr, "Allow the service and all of its jobs to run as root"},
    {"cores", "--cores", "N",
     "Number of cores for all running jobs together. Default: all; 1024 on a batch "
     "system"},
    {"memory", "--memory", "SIZE",
     "Memory for all running jobs together, for example 24GB. Default: 3/4 of the machine's "
     "memory; 4TB on a batch system"},
    {"disk_reserve", "--disk-reserve", "SIZE",
     "Minimum free disk space; below it, no job starts and running jobs are held. Default: 1GB"},
    {"slice", "--slice", "TIME",
     "Minimum running time of a job before it yields to waiting jobs. Default: 10s"},
    {"keep_days", "--keep-days", "N",
     "Days until a finished job is deleted, unless it is pinned. Default: 30"},
    {"keep_bytes", "--keep-bytes", "SIZE",
     "Maximum disk space of finished jobs; if they exceed it, the oldest unpinned jobs are "
     "deleted. Default: 50GB"},
    {"cache_mb", "--cache", "MB",
     "Size of the simulation cache of each process, in MB. Default: 256"},
};

}  // namespace

void add_setting_options(CLI::App& app, std::vector<config::Given>& given) {
  for (const SettingOption& setting : k_options) {
    if (setting.type == nullptr) {
      const auto switch_on = [&given, &setting] {
        given.push_back({.key = setting.key, .text = "true", .given_by = setting.option});
      };
      app.add_flag_callback(setting.option, switch_on, setting.help);
      continue;
    }
    app.add_option_function<std::string>(
           setting.option,
           [&given, &setting](const std::string& text) {
             given.push_back({.key = setting.key, .text = text, .given_by = setting.option});
           },
           setting.help)
        ->type_name(setting.type);
  }
}

void build_daemon_app(CLI::App& app, std::vector<config::Given>& given) {
  app.name("sleightd");
  app.failure_message(usage_words);
  app.description(
      "Sleight's service: accepts direction requests as jobs and runs them. To start the service\n"
      "in the background, run `sleight server start`.");
  app.set_version_flag("--version", version_text());
  add_setting_options(app, given);
  app.footer(
      "To list all settings and the source of each, run `sleight config`.\n\n"
      "Examples:\n  sleightd\n"
      "  sleightd --state /scratch/ada/sleight --cores 8 --memory 24GB\n"
      "  sleightd --listen 0.0.0.0:7423");
}

}  // namespace sleight::programs
