// The settings of the service on this machine, and where each comes from.
//
// Nothing needs configuring: each setting has a default. A setting comes from the first of these
// that gives it:
//
//   1. the command line
//   2. the environment: SLEIGHT_STATE, SLEIGHT_SOCKET, SLEIGHT_SERVER, SLEIGHT_ALLOW_ROOT
//   3. the file $XDG_CONFIG_HOME/sleight/config.toml, else ~/.config/sleight/config.toml
//   4. the default, which may depend on the machine or on another setting
//
// The file is TOML; all its keys are optional:
//
//   state = "/scratch/ada/sleight"
//   cores = 8
//   memory = "24 GB"
//   slice = "10s"
//
//   [limits]           # of each user
//   jobs = 100
//
//   [slurm]            # where backend = "slurm"
//   partition = "batch"
//
// Invariants
//   1. Every value is in the range that its key states, wherever it came from.
//   2. Paths are absolute; a socket's fits into a sockaddr_un.
//   3. Settings are a function of what settings_of is given. It touches no file and no environment;
//      settings_here does.
// Values; thread-safe as such, apart from settings_here, which reads the environment.
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

/// "default", "file", "environment", "command line".
std::string_view name_of(Origin origin);

template <class T>
struct Setting {
  T value{};
  Origin origin = Origin::fallback;
  /// What gave it: "/people/ada/.config/sleight/config.toml:3:1", "SLEIGHT_STATE", "--cores"; empty
  /// of a default.
  std::string given_by{};
  friend bool operator==(const Setting&, const Setting&) = default;
};

/// What one user may have at a time; without a value there is no limit.
struct UserLimits {
  Setting<std::optional<std::uint64_t>> jobs;        ///< that have not ended
  Setting<std::optional<std::uint64_t>> cores;       ///< of running jobs
  Setting<std::optional<std::uint64_t>> core_hours;  ///< of all jobs that are still kept
  Setting<std::optional<std::uint64_t>> bytes;       ///< of the folders of all jobs that are kept
  // Of one job: more is refused, with the sum (service/daemon/request_cost.h).
  Setting<std::optional<std::uint64_t>> states;       ///< chains x temperatures or particles
  Setting<std::optional<std::uint64_t>> simulations;  ///< as far as [stop] says how many
  friend bool operator==(const UserLimits&, const UserLimits&) = default;
};

/// Of jobs under Slurm that don't say otherwise, as sbatch takes them; empty: Slurm's own.
struct SlurmDefaults {
  Setting<std::string> account;
  Setting<std::string> partition;
  Setting<std::string> qos;
  Setting<std::string> time;
  Setting<std::string> more;    ///< further options of sbatch, between spaces
  Setting<std::string> script;  ///< direct.sbatch; empty: the one that is installed
  friend bool operator==(const SlurmDefaults&, const SlurmDefaults&) = default;
};

struct Settings {
  Setting<std::string> server;                ///< whose commands are for a service elsewhere
  Setting<std::string> state;                 ///< the daemon's folder
  Setting<std::string> socket;                ///< default: "socket" in `state`
  Setting<std::string> group;                 ///< of users who may call the daemon; empty: nobody
  Setting<std::string> listen;                ///< over TLS: "0.0.0.0:7423"; empty: nowhere
  Setting<std::string> tls_certificate;       ///< PEM; empty: of its own making
  Setting<std::string> tls_key;               ///< with tls_certificate
  Setting<std::string> backend;               ///< "local", "slurm", or a program's path
  Setting<bool> allow_root;                   ///< the daemon, and so every job, may be root's
  Setting<std::uint64_t> cores;               ///< for all jobs together; default: all of them
  Setting<std::uint64_t> job_cores;           ///< of a job that doesn't say; 0: what is free
  Setting<std::uint64_t> memory_bytes;        ///< `memory`, for all jobs; default: 3/4 of it
  Setting<std::uint64_t> disk_reserve_bytes;  ///< `disk_reserve`: below this nothing starts
  Setting<double> slice_s;                    ///< `slice`: a job runs so long before it yields
  Setting<std::uint64_t> keep_days;           ///< finished jobs are kept so long
  Setting<std::uint64_t> keep_bytes;          ///< finished jobs take up at most this together
  Setting<std::uint64_t> cache_mb;            ///< of each process of a job, as --cache
  UserLimits limits;                          ///< `[limits]`
  SlurmDefaults slurm;                        ///< `[slurm]`
  friend bool operator==(const Settings&, const Settings&) = default;
};

inline constexpr std::uint64_t k_disk_reserve_bytes = 1'000'000'000;
/// A job that waits behind a full machine starts after this and the running job's orderly stop: of
/// the 15 s in which another user's short job is to end, 10 are the slice.
inline constexpr double k_slice_s = 10;
inline constexpr std::uint64_t k_keep_days = 30;
inline constexpr std::uint64_t k_keep_bytes = 50'000'000'000;
/// As run::k_cache_bytes_max, which this side can't see; tests/programs compare them.
inline constexpr std::uint64_t k_cache_mb = 256;
inline constexpr std::uint64_t k_jobs_of_user = 20'000;
// Where a batch system runs the jobs: what they may have of it, if nothing is said.
inline constexpr std::uint64_t k_system_cores = 1024;
inline constexpr std::uint64_t k_system_memory_bytes = 4'000'000'000'000;
inline constexpr std::uint64_t k_system_job_cores = 4;
inline constexpr std::uint64_t k_states_of_job = 16'384;
inline constexpr std::uint64_t k_simulations_of_job = 100'000'000'000;
inline constexpr std::uint64_t k_cores_max = 65'536;
/// Where a machine's daemon listens by convention: clients call it where no daemon of their own is.
inline constexpr std::string_view k_machine_socket = "/run/sleight/socket";
/// A path in a sockaddr_un, its final zero aside.
inline constexpr std::size_t k_socket_path_bytes_max = 107;

/// What settings depend on beside the file.
struct Surroundings {
  /// A variable of the environment; none where it is not set.
  std::function<std::optional<std::string>(std::string_view name)> variable;
  std::uint64_t cores = 1;         ///< that this process may run on; at least 1
  std::uint64_t memory_bytes = 0;  ///< of the machine
};

/// The file's place and content.
struct ConfigFile {
  std::string path;
  std::string text;
};

/// A setting that the command line gives, as text: {"cores", "8", "--cores"},
/// {"limits.jobs", "5", "--jobs"}. Sizes and times as in quantities.h.
struct Given {
  std::string key;
  std::string text;
  std::string given_by;
};

/// The settings, or everything that is wrong: in the file with its place, elsewhere by the name of
/// what gave it (request::k_no_place). REQUIRES: the keys of `command_line` exist.
base::Result<Settings, std::vector<request::Diagnostic>> settings_of(
    const Surroundings& surroundings, const std::optional<ConfigFile>& file,
    const std::vector<Given>& command_line = {});

/// Where the file lies; none where neither XDG_CONFIG_HOME nor HOME is an absolute path.
std::optional<std::string> config_path_of(const Surroundings& surroundings);

/// A setting for people and for JSON.
struct Row {
  std::string key;    ///< "cores", "limits.jobs"
  std::string value;  ///< as the file would have it, without quotes; "none" without a limit
  std::string unit;   ///< of `number`: "bytes", "s", "days", "cores"; empty of text
  std::optional<double> number;  ///< of what is no text; none: text, or no limit
  bool is_text = false;
  bool is_flag = false;  ///< `value` is "true" or "false"
  Origin origin = Origin::fallback;
  std::string given_by;
  std::string help;  ///< one line
};

/// All settings, in the order of Settings.
std::vector<Row> rows_of(const Settings& settings);

/// Environment, machine and file of this process. Throws base::Error: usage, with a line for each
/// error in them; environment, where the file can't be read.
Settings settings_here(const std::vector<Given>& command_line = {});

/// Where this process's calls go: the server or the socket that is set, else that of its user's own
/// daemon, else, where there is only that, the machine's. Throws as settings_here.
/// "HOST:PORT" where `server` is set, else a path.
struct ToCall {
  std::string socket{};
  std::string server{};  ///< empty: the socket
};
ToCall service_to_call();

/// What settings_here looks at.
Surroundings surroundings_here();

}  // namespace sleight::config
