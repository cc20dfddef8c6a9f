// The settings of the service on this machine. Each setting records where it was set.
//
// Every setting has a default, so nothing needs configuring. A setting comes from the first of
// these sources that has it:
//
//   1. the command line;
//   2. the environment: SLEIGHT_STATE, SLEIGHT_SOCKET, SLEIGHT_SERVER, SLEIGHT_ALLOW_ROOT;
//   3. the file $XDG_CONFIG_HOME/sleight/config.toml, else ~/.config/sleight/config.toml;
//   4. the default, which may depend on the machine or on another setting.
//
// The file is TOML. All keys are optional:
//
//   state = "/scratch/ada/sleight"
//   cores = 8
//   memory = "24 GB"
//   slice = "10s"
//
//   [limits]           # per user
//   jobs = 100
//
//   [slurm]            # if backend = "slurm"
//   partition = "batch"
//
// Invariants
//   1. Every value is within its key's range, wherever it was set.
//   2. Paths are absolute; a socket's path fits into a sockaddr_un.
//   3. Settings are a function of settings_of's arguments. Only settings_here accesses the file and
//      the environment.
// Thread safety: values and pure functions, except settings_here, which reads the environment.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/request/diagnostic.h"

namespace sleight::config {

enum class Origin { fallback, file, environment, command_line };

/// Returns "default", "file", "environment" or "command line".
std::string_view name_of(Origin origin);

template <class T>
struct Setting {
  T value{};
  Origin origin = Origin::fallback;
  /// Source of the value: "/people/ada/.config/sleight/config.toml:3:1", "SLEIGHT_STATE",
  /// "--cores". Empty for a default.
  std::string given_by{};
  friend bool operator==(const Setting&, const Setting&) = default;
};

/// Limits for one user. No value: no limit.
struct UserLimits {
  Setting<std::optional<std::uint64_t>> jobs;        ///< unfinished jobs
  Setting<std::optional<std::uint64_t>> cores;       ///< of running jobs
  Setting<std::optional<std::uint64_t>> core_hours;  ///< of all jobs still stored
  Setting<std::optional<std::uint64_t>> bytes;       ///< of the folders of all jobs still stored
  // Limits for one job. If a job exceeds a limit, the error message shows how the job's size was
  // calculated (service/daemon/request_cost.h).
  Setting<std::optional<std::uint64_t>> states;       ///< chains x temperatures or particles
  Setting<std::optional<std::uint64_t>> simulations;  ///< as far as [stop] determines their number
  friend bool operator==(const UserLimits&, const UserLimits&) = default;
};

/// Default options for submitting jobs with sbatch. Empty: Slurm's own defaults.
struct SlurmDefaults {
  Setting<std::string> account;
  Setting<std::string> partition;
  Setting<std::string> qos;
  Setting<std::string> time;
  Setting<std::string> more;    ///< further options of sbatch, separated by spaces
  Setting<std::string> script;  ///< direct.sbatch; empty: the installed one
  friend bool operator==(const SlurmDefaults&, const SlurmDefaults&) = default;
};

struct Settings {
  Setting<std::string> server;           ///< remote server for `sleight` commands
  Setting<std::string> state;            ///< the daemon's folder
  Setting<std::string> socket;           ///< default: "socket" in `state`
  Setting<std::string> group;            ///< users who may call the daemon; empty: none
  Setting<std::string> listen;           ///< TLS address: "0.0.0.0:7423"; empty: none
  Setting<std::string> tls_certificate;  ///< PEM; empty: self-signed
  Setting<std::string> tls_key;          ///< belongs to tls_certificate
  Setting<std::string> backend;          ///< "local", "slurm", or a program's path
  Setting<bool> allow_root;              ///< allow the daemon, and so every job, to run as root
  Setting<std::uint64_t> cores;          ///< for all jobs together; default: all cores
  Setting<std::uint64_t> job_cores;      ///< default per job; 0: all free cores
  Setting<std::uint64_t> memory_bytes;   ///< `memory`, for all jobs; default: 3/4 of the machine's
  Setting<std::uint64_t> disk_reserve_bytes;  ///< `disk_reserve`: with less free, no job starts
  Setting<double> slice_s;                    ///< `slice`: time that a job runs before it yields
  Setting<std::uint64_t> keep_days;           ///< time until finished jobs are deleted
  Setting<std::uint64_t> keep_bytes;          ///< maximum size of all finished jobs
  Setting<std::uint64_t> cache_mb;            ///< per process of a job, see --cache
  UserLimits limits;                          ///< `[limits]`
  SlurmDefaults slurm;                        ///< `[slurm]`
  friend bool operator==(const Settings&, const Settings&) = default;
};

inline constexpr std::uint64_t k_disk_reserve_bytes = 1'000'000'000;
/// A waiting job starts when the running job's slice is over and the running job has stopped. A
/// user's short job should finish within 15 s, even if another user's job is running; the slice
/// takes 10 s of this time.
inline constexpr double k_slice_s = 10;
inline constexpr std::uint64_t k_keep_days = 30;
inline constexpr std::uint64_t k_keep_bytes = 50'000'000'000;
/// Has the same size as run::k_cache_bytes_max. This library can't include that constant. A test
/// compares both values.
inline constexpr std::uint64_t k_cache_mb = 256;
inline constexpr std::uint64_t k_jobs_of_user = 20'000;
// Defaults for the total resources of all jobs under a batch system.
inline constexpr std::uint64_t k_system_cores = 1024;
inline constexpr std::uint64_t k_system_memory_bytes = 4'000'000'000'000;
inline constexpr std::uint64_t k_system_job_cores = 4;
inline constexpr std::uint64_t k_states_of_job = 16'384;
inline constexpr std::uint64_t k_simulations_of_job = 100'000'000'000;
inline constexpr std::uint64_t k_cores_max = 65'536;
/// The usual socket of a machine's daemon. Clients use this socket if their user has no daemon.
inline constexpr std::string_view k_machine_socket = "/run/sleight/socket";
/// Longest path in a sockaddr_un, without the final zero.
inline constexpr std::size_t k_socket_path_bytes_max = 107;

struct Surroundings {
  /// Returns an environment variable; nothing if it is unset.
  std::function<std::optional<std::string>(std::string_view name)> variable;
  std::uint64_t cores = 1;         ///< available to this process; at least 1
  std::uint64_t memory_bytes = 0;  ///< of the machine
};

struct ConfigFile {
  std::string path;
  std::string text;
};

/// A setting from the command line, such as {"cores", "8", "--cores"} or {"limits.jobs", "5",
/// "--jobs"}. Sizes and times are as in quantities.h.
struct Given {
  std::string key;
  std::string text;
  std::string given_by;
};

/// Returns the settings, or all errors. An error in the file names its place. Any other error names
/// its source and has the place request::k_no_place. REQUIRES: the keys of `command_line` exist.
base::Result<Settings, std::vector<request::Diagnostic>> settings_of(
    const Surroundings& surroundings, const std::optional<ConfigFile>& file,
    const std::vector<Given>& command_line = {});

/// Returns the file's path; nothing if neither XDG_CONFIG_HOME nor HOME is an absolute path.
std::optional<std::string> config_path_of(const Surroundings& surroundings);

struct Row {
  std::string key;               ///< such as "cores" or "limits.jobs"
  std::string value;             ///< as in the file, without quotes; "none": no limit
  std::string unit;              ///< of `number`: "bytes", "s", "days", "cores"; empty for text
  std::optional<double> number;  ///< empty: text, or no limit
  bool is_text = false;
  bool is_flag = false;  ///< `value` is "true" or "false"
  Origin origin = Origin::fallback;
  std::string given_by;
  std::string help;  ///< one line
};

/// Returns all settings, in the order of Settings.
std::vector<Row> rows_of(const Settings& settings);

/// Returns the settings of this process's environment, machine and file. Throws base::Error(usage),
/// with one line per error. If the file can't be read, throws base::Error(environment).
Settings settings_here(const std::vector<Given>& command_line = {});

/// The service that this process calls: the configured server or socket. If none is configured, the
/// service is this user's daemon, or the machine's daemon if only that exists. `server` is
/// "HOST:PORT", `socket` a path. Throws like settings_here.
struct ToCall {
  std::string socket{};
  std::string server{};  ///< empty: use the socket
};
ToCall service_to_call();

Surroundings surroundings_here();

}  // namespace sleight::config
