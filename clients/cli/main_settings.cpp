#include "clients/cli/main_settings.h"

#include <string>

#include "clients/cli/main_run.h"

namespace sleight::programs {
namespace {

/// A setting that a daemon's start may give; all others are the file's.
struct SettingOption {
  const char* key;
  const char* option;
  const char* type;  ///< null: a flag
  const char* help;
};

constexpr SettingOption k_options[] = {
    {"state", "--state", "FOLDER", "Folder of the daemon: its jobs, their archives, its log"},
    {"socket", "--socket", "PATH", "Where the daemon is called"},
    {"group", "--group", "NAME", "Group whose members may use the daemon, beside its own user"},
    {"listen", "--listen", "ADDRESS",
     "Where the daemon is called from other machines, over TLS (0.0.0.0:7423)"},
    {"tls_certificate", "--tls-certificate", "FILE",
     "Absolute path of the daemon's TLS certificate, in PEM. Default: one that it makes itself"},
    {"tls_key", "--tls-key", "FILE", "Absolute path of that certificate's key, in PEM"},
    {"backend", "--backend", "NAME",
     "What runs jobs: local (this machine), slurm, or a program's path"},
    {"allow_root", "--allow-root", nullptr, "The daemon may run as root, and so may every job"},
    {"cores", "--cores", "N", "For all running jobs together"},
    {"memory", "--memory", "SIZE", "For all running jobs together (24GB)"},
    {"disk_reserve", "--disk-reserve", "SIZE",
     "With less free on the disk nothing starts and running jobs are held"},
    {"slice", "--slice", "TIME",
     "Least time for which a job runs before it yields to waiting ones"},
    {"keep_days", "--keep-days", "N", "Days after which a finished job is deleted, unless pinned"},
    {"keep_bytes", "--keep-bytes", "SIZE",
     "Most that finished jobs keep on the disk; beyond it the oldest go that are not pinned"},
    {"cache_mb", "--cache", "MB", "Memory in which each process of a job keeps simulations"},
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
  app.description(
      "Sleight's service: takes direction requests as jobs and runs them.\n"
      "`sleight server start` starts it in the background.");
  app.set_version_flag("--version", version_text());
  add_setting_options(app, given);
  app.footer(
      "`sleight config` shows the settings that hold and where each comes from.\n\nExamples:\n"
      "  sleightd\n"
      "  sleightd --state /scratch/ada/sleight --cores 8 --memory 24GB\n"
      "  sleightd --listen 0.0.0.0:7423");
}

}  // namespace sleight::programs
