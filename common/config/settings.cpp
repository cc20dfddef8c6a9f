#include "common/config/settings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <iterator>
#include <utility>

#include "common/access/server_address.h"
#include "common/base/check.h"
#include "common/config/quantities.h"
#include "common/request/document.h"
#include "common/request/nearest.h"
#include "common/request/text.h"

namespace sleight::config {
namespace {

using request::Diagnostics;
using request::Document;
using request::Entry;
using request::Place;
using request::Value;

constexpr std::uint64_t k_integer_max = 1'000'000'000'000;
constexpr std::size_t k_shown_characters_max = 60;
constexpr std::size_t k_name_bytes_max = 255;
constexpr std::string_view k_sections[] = {"limits", "slurm"};

struct Range {
  std::uint64_t minimum = 0;
  std::uint64_t maximum = k_integer_max;
  std::string_view unit = "";
};

/// Lists each key once, with its name, member, type and help. A visitor has functions `path`,
/// `name`, `address`, `flag`, `count`, `bytes` and `duration_s`; `count` and `bytes` also have
/// overloads for limits.
template <class AnySettings, class Visitor>
void visit(AnySettings& s, Visitor& visitor) {
  visitor.path("state", s.state, "folder for jobs, archives and the log");
  visitor.path("socket", s.socket, "path of the service's Unix socket");
  visitor.name("group", s.group,
               "group whose members may use the service, in addition to the user who runs it");
  visitor.address("listen", s.listen,
                  "address at which the service accepts TLS connections from other machines");
  visitor.path("tls_certificate", s.tls_certificate,
               "TLS certificate (absolute path, PEM); default: self-signed");
  visitor.path("tls_key", s.tls_key, "private key of tls_certificate (absolute path, PEM)");
  visitor.name("backend", s.backend,
               "system that runs jobs: \"local\" (this machine), \"slurm\", or a program's path");
  visitor.flag("allow_root", s.allow_root, "allow the service and its jobs to run as root");
  visitor.count("cores", s.cores, Range{1, k_cores_max, "cores"},
                "total number of cores for all running jobs");
  visitor.count("job_cores", s.job_cores, Range{0, k_cores_max, "cores"},
                "default number of cores of a job; 0: all free cores");
  visitor.bytes("memory", s.memory_bytes, 1, "total memory for all running jobs");
  visitor.bytes("disk_reserve", s.disk_reserve_bytes, 0,
                "minimum free disk space; below it, no job starts and running jobs are held");
  visitor.duration_s("slice", s.slice_s,
                     "minimum time for which a job runs before it yields to waiting jobs");
  visitor.count("keep_days", s.keep_days, Range{0, 36500, "days"},
                "days until a finished job is deleted, unless pinned");
  visitor.bytes(
      "keep_bytes", s.keep_bytes, 0,
      "maximum disk space of finished jobs; beyond it, the oldest unpinned jobs are deleted");
  visitor.count("cache_mb", s.cache_mb, Range{0, 1'000'000, "MB"},
                "size of the simulation cache in each process of a job, in MB");
  visitor.address("server", s.server,
                  "address of a service on another machine, to which commands connect over TLS");
  visitor.count("limits.jobs", s.limits.jobs, Range{1, k_integer_max, "jobs"},
                "maximum unfinished jobs of a user");
  visitor.count("limits.cores", s.limits.cores, Range{1, k_cores_max, "cores"},
                "maximum cores of a user's running jobs");
  visitor.count("limits.core_hours", s.limits.core_hours, Range{1, k_integer_max, "core-hours"},
                "maximum core-hours of a user per day");
  visitor.bytes("limits.bytes", s.limits.bytes, 1, "maximum disk space of a user's jobs");
  visitor.count("limits.states", s.limits.states, Range{1, k_integer_max, "states"},
                "maximum number of states of a job: chains x temperatures, or chains x particles");
  visitor.count("limits.simulations", s.limits.simulations, Range{1, k_integer_max, "simulations"},
                "maximum number of simulations of a job; applies if [stop] sets scans or rounds");
  visitor.name("slurm.account", s.slurm.account, "default account of jobs");
  visitor.name("slurm.partition", s.slurm.partition, "default partition of jobs");
  visitor.name("slurm.qos", s.slurm.qos, "default quality of service of jobs");
  visitor.name("slurm.time", s.slurm.time, "default time limit of each attempt of a job");
  visitor.name("slurm.more", s.slurm.more, "further sbatch options, such as --exclusive");
  visitor.path("slurm.script", s.slurm.script,
               "batch script (absolute path); default: the installed direct.sbatch");
}

struct Found {
  Value value;
  Origin origin = Origin::fallback;
  std::string given_by;
  Place place = request::k_no_place;  ///< in the file
};

/// Converts text from the command line or the environment to a value. Digits become an integer.
Value value_of(const std::string& text) {
  std::int64_t integer = 0;
  const char* end = text.data() + text.size();
  const auto [rest, failure] = std::from_chars(text.data(), end, integer);
  if (failure == std::errc() && rest == end) return {integer, request::k_no_place};
  return {text, request::k_no_place};
}

/// Reads each key from the first source that has it, and collects errors.
class Reader {
 public:
  Reader(const Surroundings& surroundings, const std::string& file, const Document& document,
         const std::vector<Given>& command_line, std::vector<request::Diagnostic>& wrong)
      : surroundings_(surroundings),
        file_(file),
        in_file_(file),
        document_(document),
        command_line_(command_line),
        wrong_(wrong) {}

  void path(std::string_view key, Setting<std::string>& setting, std::string_view /*help*/) {
    const std::optional<Found> found = find(key);
    if (!found) return;
    const auto* text = std::get_if<std::string>(&found->value.held);
    if (text == nullptr) return refuse(key, *found, "a path as a string");
    std::string path = *text;
    if (path == "~" || path.starts_with("~/")) {
      const auto home = surroundings_.variable("HOME");
      if (home) path = *home + path.substr(1);
    }
    if (!path.starts_with('/') || path.find('\0') != std::string::npos)
      return refuse(key, *found, "an absolute path, \"/...\" or \"~/...\"");
    take(setting, std::move(path), *found);
  }

  void name(std::string_view key, Setting<std::string>& setting, std::string_view /*help*/) {
    const std::optional<Found> found = find(key);
    if (!found) return;
    const auto* text = std::get_if<std::string>(&found->value.held);
    if (text == nullptr || text->empty() || text->size() > k_name_bytes_max ||
        text->find('\0') != std::string::npos)
      return refuse(key, *found, "a name as a string");
    take(setting, *text, *found);
  }

  void address(std::string_view key, Setting<std::string>& setting, std::string_view /*help*/) {
    const std::optional<Found> found = find(key);
    if (!found) return;
    const auto* text = std::get_if<std::string>(&found->value.held);
    const auto address = text == nullptr ? std::nullopt : access::server_address_of(*text);
    if (!address)
      return refuse(key, *found, "an address such as \"render.example.org:7423\" or \"0.0.0.0\"");
    take(setting, access::text_of(*address), *found);
  }

  void flag(std::string_view key, Setting<bool>& setting, std::string_view /*help*/) {
    const std::optional<Found> found = find(key);
    if (!found) return;
    std::optional<bool> is_on;
    if (const auto* held = std::get_if<bool>(&found->value.held)) is_on = *held;
    // The command line and the environment contain only text.
    if (found->origin != Origin::file) {
      const auto* text = std::get_if<std::string>(&found->value.held);
      if (text != nullptr && (*text == "true" || *text == "1")) is_on = true;
      if (text != nullptr && (*text == "false" || *text == "0")) is_on = false;
    }
    if (!is_on) return refuse(key, *found, "true or false");
    take(setting, bool{*is_on}, *found);
  }

  template <class T>
  void count(std::string_view key, Setting<T>& setting, const Range& range,
             std::string_view /*help*/) {
    const std::optional<Found> found = find(key);
    if (!found) return;
    const auto* integer = std::get_if<std::int64_t>(&found->value.held);
    if (integer == nullptr || *integer < 0 ||
        static_cast<std::uint64_t>(*integer) < range.minimum ||
        static_cast<std::uint64_t>(*integer) > range.maximum) {
      return refuse(
          key, *found,
          fmt::format("an integer from {} to {} ({})", range.minimum, range.maximum, range.unit));
    }
    take(setting, static_cast<std::uint64_t>(*integer), *found);
  }

  template <class T>
  void bytes(std::string_view key, Setting<T>& setting, std::uint64_t minimum,
             std::string_view /*help*/) {
    const std::optional<Found> found = find(key);
    if (!found) return;
    std::optional<std::uint64_t> bytes;
    if (const auto* text = std::get_if<std::string>(&found->value.held)) bytes = bytes_of(*text);
    if (const auto* integer = std::get_if<std::int64_t>(&found->value.held)) {
      if (*integer >= 0 && static_cast<std::uint64_t>(*integer) <= k_bytes_max)
        bytes = static_cast<std::uint64_t>(*integer);
    }
    if (!bytes || *bytes < minimum) {
      return refuse(key, *found,
                    fmt::format("a size from {} to 9 PB, such as \"24 GB\", \"500 MB\" or "
                                "a number of bytes",
                                minimum == 0 ? "0" : "1 byte"));
    }
    take(setting, *bytes, *found);
  }

  void duration_s(std::string_view key, Setting<double>& setting, std::string_view /*help*/) {
    const std::optional<Found> found = find(key);
    if (!found) return;
    std::optional<double> duration_s;
    if (const auto* text = std::get_if<std::string>(&found->value.held))
      duration_s = duration_s_of(*text);
    if (const auto* integer = std::get_if<std::int64_t>(&found->value.held))
      duration_s = duration_s_of(fmt::format("{}", *integer));
    if (!duration_s) return refuse(key, *found, "a time such as \"10s\", \"5m\" or \"1.5h\"");
    take(setting, *duration_s, *found);
  }

  /// REQUIRES: every key has been read.
  void report_unknown() {
    for (const Given& given : command_line_)
      CHECK(std::find(keys_.begin(), keys_.end(), given.key) != keys_.end());
    for (const Entry& entry : document_.loose)
      unknown(entry, entry.key, is_section(entry.key));
    for (const request::Section& section : document_.sections) {
      if (!is_section(section.name)) {
        in_file_.add(section.place,
                     fmt::format("unknown section [{}]; known sections: [{}]; keys without a "
                                 "section belong before the first section",
                                 shown(section.name), fmt::join(k_sections, "], [")));
        continue;
      }
      for (const Entry& entry : section.entries)
        unknown(entry, fmt::format("{}.{}", section.name, entry.key), false);
    }
    const std::vector<request::Diagnostic> of_file = in_file_.sorted();
    wrong_.insert(wrong_.end(), of_file.begin(), of_file.end());
  }

 private:
  static std::string shown(std::string_view text) {
    return request::printable(text, k_shown_characters_max);
  }

  static bool is_section(std::string_view name) {
    return std::find(std::begin(k_sections), std::end(k_sections), name) != std::end(k_sections);
  }

  /// Returns a key's name for messages, such as "'jobs' in [limits]" or "'cores'".
  static std::string name_in_file(std::string_view key) {
    const std::size_t dot = key.find('.');
    if (dot == std::string_view::npos) return fmt::format("'{}'", key);
    return fmt::format("'{}' in [{}]", key.substr(dot + 1), key.substr(0, dot));
  }

  std::optional<Found> find(std::string_view key) {
    keys_.emplace_back(key);
    for (const Given& given : command_line_) {
      if (given.key == key)
        return Found{value_of(given.text), Origin::command_line, given.given_by};
    }
    const std::string_view name = key == "state"        ? "SLEIGHT_STATE"
                                  : key == "socket"     ? "SLEIGHT_SOCKET"
                                  : key == "server"     ? "SLEIGHT_SERVER"
                                  : key == "allow_root" ? "SLEIGHT_ALLOW_ROOT"
                                                        : "";
    if (!name.empty()) {
      // Treat an empty variable as unset. Shell users disable a variable by emptying it.
      const auto text = surroundings_.variable(name);
      if (text && !text->empty())
        return Found{{*text, request::k_no_place}, Origin::environment, std::string(name)};
    }
    const Entry* entry = find_in_file(key);
    if (entry == nullptr) return std::nullopt;
    return Found{entry->value, Origin::file,
                 fmt::format("{}:{}:{}", file_, entry->place.line, entry->place.column),
                 entry->value.place};
  }

  const Entry* find_in_file(std::string_view key) const {
    const std::size_t dot = key.find('.');
    if (dot != std::string_view::npos) {
      const request::Section* section = document_.find(key.substr(0, dot));
      return section == nullptr ? nullptr : section->find(key.substr(dot + 1));
    }
    const auto at = std::find_if(document_.loose.begin(), document_.loose.end(),
                                 [&](const Entry& entry) { return entry.key == key; });
    return at == document_.loose.end() ? nullptr : &*at;
  }

  template <class T, class V>
  void take(Setting<T>& setting, V value, const Found& found) {
    setting.value = std::move(value);
    setting.origin = found.origin;
    setting.given_by = found.given_by;
  }

  void refuse(std::string_view key, const Found& found, std::string_view expected) {
    std::string message =
        fmt::format("expected {}, found {}", expected, request::description(found.value));
    if (found.origin == Origin::file) {
      in_file_.add(found.place, fmt::format("{}: {}", name_in_file(key), message));
    } else {
      wrong_.push_back({found.given_by, request::k_no_place, std::move(message)});
    }
  }

  void unknown(const Entry& entry, const std::string& name, bool is_of_section) {
    if (std::find(keys_.begin(), keys_.end(), name) != keys_.end()) return;
    if (is_of_section) {
      return in_file_.add(entry.place, fmt::format("'{0}' must be a section, with the line [{0}] "
                                                   "above its keys",
                                                   entry.key));
    }
    // First look for the key in other sections, because a wrong section is more likely than a
    // typing error.
    std::string_view other_section;
    for (const std::string_view section : k_sections) {
      const std::string there = fmt::format("{}.{}", section, entry.key);
      if (name != there && std::find(keys_.begin(), keys_.end(), there) != keys_.end())
        other_section = section;
    }
    const bool is_misplaced =
        name != entry.key && std::find(keys_.begin(), keys_.end(), entry.key) != keys_.end();
    const auto near = request::nearest(name, keys_);
    in_file_.add(
        entry.place,
        fmt::format("unknown key {}; {}", name_in_file(shown(name)),
                    !other_section.empty() ? fmt::format("it belongs in [{}]", other_section)
                    : is_misplaced         ? "this key belongs before the first section"
                    : near                 ? fmt::format("did you mean {}?", name_in_file(*near))
                           : fmt::format("known keys: {}", fmt::join(keys_, ", "))));
  }

  const Surroundings& surroundings_;
  const std::string& file_;
  Diagnostics in_file_;
  const Document& document_;
  const std::vector<Given>& command_line_;
  std::vector<request::Diagnostic>& wrong_;
  std::vector<std::string> keys_;
};

/// Returns a folder by the XDG specification. Ignores relative paths, as the specification
/// requires.
std::optional<std::string> xdg_folder(const Surroundings& surroundings, std::string_view name,
                                      std::string_view below_home) {
  const auto is_absolute = [](const std::optional<std::string>& path) {
    return path && path->starts_with('/');
  };
  const auto given = surroundings.variable(name);
  if (is_absolute(given)) return *given + "/sleight";
  const auto home = surroundings.variable("HOME");
  if (is_absolute(home)) return fmt::format("{}/{}/sleight", *home, below_home);
  return std::nullopt;
}

Settings defaults_of(const Surroundings& surroundings) {
  CHECK_GE(surroundings.cores, 1U);
  Settings settings;
  settings.state.value = xdg_folder(surroundings, "XDG_STATE_HOME", ".local/state").value_or("");
  settings.cores.value = std::min(surroundings.cores, k_cores_max);
  // Round to whole megabytes, which are easier to read.
  constexpr std::uint64_t k_megabyte = 1'000'000;
  settings.memory_bytes.value =
      std::max(surroundings.memory_bytes / 4 * 3 / k_megabyte * k_megabyte, k_megabyte);
  settings.disk_reserve_bytes.value = k_disk_reserve_bytes;
  settings.slice_s.value = k_slice_s;
  settings.keep_days.value = k_keep_days;
  settings.keep_bytes.value = k_keep_bytes;
  settings.cache_mb.value = k_cache_mb;
  settings.limits.jobs.value = k_jobs_of_user;
  settings.limits.states.value = k_states_of_job;
  settings.limits.simulations.value = k_simulations_of_job;
  settings.backend.value = "local";
  return settings;
}

void settle_certificate(const Settings& settings, std::vector<request::Diagnostic>& wrong) {
  const auto& certificate = settings.tls_certificate;
  const auto& key = settings.tls_key;
  if (certificate.value.empty() == key.value.empty()) return;
  wrong.push_back({certificate.value.empty() ? key.given_by : certificate.given_by,
                   request::k_no_place,
                   certificate.value.empty() ? "tls_key requires tls_certificate"
                                             : "tls_certificate requires tls_key"});
}

/// Under a batch system, the defaults for jobs' resources don't depend on the daemon's machine.
void settle_backend(Settings& settings, std::vector<request::Diagnostic>& wrong) {
  const std::string& backend = settings.backend.value;
  if (backend == "local") return;
  if (backend == "slurm" || backend.starts_with('/')) {
    const auto settle = [](Setting<std::uint64_t>& setting, std::uint64_t value) {
      if (setting.origin == Origin::fallback) setting.value = value;
    };
    settle(settings.cores, k_system_cores);
    settle(settings.memory_bytes, k_system_memory_bytes);
    settle(settings.job_cores, k_system_job_cores);
    return;
  }
  wrong.push_back({settings.backend.given_by, request::k_no_place,
                   fmt::format("expected backend \"local\", \"slurm\" or the absolute path of a "
                               "program, found \"{}\"",
                               request::printable(backend, k_shown_characters_max))});
}

/// If no path is set for the socket, puts it into the state folder.
void settle_socket(Settings& settings, std::vector<request::Diagnostic>& wrong) {
  if (settings.state.value.empty()) {
    wrong.push_back({"HOME", request::k_no_place,
                     "expected an absolute path, because the default state folder is inside it; "
                     "alternatively, set SLEIGHT_STATE to a folder on this machine"});
    return;
  }
  const bool is_own = settings.socket.origin != Origin::fallback;
  if (!is_own) settings.socket.value = settings.state.value + "/socket";
  const bool is_in_state = settings.socket.value.starts_with(settings.state.value + "/");
  if (!settings.group.value.empty() && is_in_state) {
    wrong.push_back({settings.group.given_by, request::k_no_place,
                     fmt::format("members of the group can't open the state folder, so the socket "
                                 "must be outside the folder; set 'socket', for example to {}",
                                 k_machine_socket)});
  }
  const std::size_t bytes = settings.socket.value.size();
  if (bytes <= k_socket_path_bytes_max) return;
  const std::string& given_by = is_own ? settings.socket.given_by
                                : settings.state.origin == Origin::fallback
                                    ? "HOME"
                                    : settings.state.given_by;
  wrong.push_back({given_by, request::k_no_place,
                   fmt::format("the socket path {} has {} bytes; the maximum is {}; set "
                               "SLEIGHT_SOCKET to a shorter path",
                               request::printable(settings.socket.value, 200), bytes,
                               k_socket_path_bytes_max)});
}

class RowMaker {
 public:
  std::vector<Row> rows;

  void path(std::string_view key, const Setting<std::string>& setting, std::string_view help) {
    Row& row = add(key, setting, help);
    if (!setting.value.empty()) row.value = request::printable(setting.value, 4096);
    row.is_text = true;
  }
  void name(std::string_view key, const Setting<std::string>& setting, std::string_view help) {
    Row& row = add(key, setting, help);
    if (!setting.value.empty()) row.value = request::printable(setting.value, k_name_bytes_max);
    row.is_text = true;
  }
  void address(std::string_view key, const Setting<std::string>& setting, std::string_view help) {
    name(key, setting, help);
  }
  void flag(std::string_view key, const Setting<bool>& setting, std::string_view help) {
    Row& row = add(key, setting, help);
    row.value = setting.value ? "true" : "false";
    row.is_flag = true;
  }
  void count(std::string_view key, const Setting<std::uint64_t>& setting, const Range& range,
             std::string_view help) {
    number(add(key, setting, help), static_cast<double>(setting.value),
           fmt::format("{}", setting.value), range.unit);
  }
  void count(std::string_view key, const Setting<std::optional<std::uint64_t>>& setting,
             const Range& range, std::string_view help) {
    Row& row = add(key, setting, help);
    row.unit = std::string(range.unit);
    if (setting.value)
      number(row, static_cast<double>(*setting.value), fmt::format("{}", *setting.value),
             range.unit);
  }
  void bytes(std::string_view key, const Setting<std::uint64_t>& setting, std::uint64_t /*minimum*/,
             std::string_view help) {
    number(add(key, setting, help), static_cast<double>(setting.value), bytes_text(setting.value),
           "bytes");
  }
  void bytes(std::string_view key, const Setting<std::optional<std::uint64_t>>& setting,
             std::uint64_t /*minimum*/, std::string_view help) {
    Row& row = add(key, setting, help);
    row.unit = "bytes";
    if (setting.value)
      number(row, static_cast<double>(*setting.value), bytes_text(*setting.value), "bytes");
  }
  void duration_s(std::string_view key, const Setting<double>& setting, std::string_view help) {
    number(add(key, setting, help), setting.value, duration_text(setting.value), "s");
  }

 private:
  template <class T>
  Row& add(std::string_view key, const Setting<T>& setting, std::string_view help) {
    rows.push_back({.key = std::string(key),
                    .value = "none",
                    .unit = "",
                    .number = std::nullopt,
                    .origin = setting.origin,
                    .given_by = setting.given_by,
                    .help = std::string(help)});
    return rows.back();
  }
  static void number(Row& row, double number, std::string text, std::string_view unit) {
    row.number = number;
    row.value = std::move(text);
    row.unit = std::string(unit);
  }
};

}  // namespace

std::string_view name_of(Origin origin) {
  switch (origin) {
    case Origin::fallback:
      return "default";
    case Origin::file:
      return "file";
    case Origin::environment:
      return "environment";
    case Origin::command_line:
      return "command line";
  }
  return "?";
}

base::Result<Settings, std::vector<request::Diagnostic>> settings_of(
    const Surroundings& surroundings, const std::optional<ConfigFile>& file,
    const std::vector<Given>& command_line) {
  const std::string path = file ? request::printable(file->path, 4096) : std::string();
  Document document;
  if (file) {
    auto parsed = request::parse_document(file->text, path);
    if (!parsed) return std::vector{parsed.error()};
    document = std::move(parsed).value();
  }

  // Each key is read from the first source that has it. Unknown keys of the file are errors.
  Settings settings = defaults_of(surroundings);
  std::vector<request::Diagnostic> wrong;
  Reader reader(surroundings, path, document, command_line, wrong);
  visit(settings, reader);
  reader.report_unknown();
  if (wrong.empty()) {
    settle_certificate(settings, wrong);
    settle_backend(settings, wrong);
    settle_socket(settings, wrong);
  }
  if (!wrong.empty()) return wrong;
  return settings;
}

std::optional<std::string> config_path_of(const Surroundings& surroundings) {
  const auto folder = xdg_folder(surroundings, "XDG_CONFIG_HOME", ".config");
  if (!folder) return std::nullopt;
  return *folder + "/config.toml";
}

std::vector<Row> rows_of(const Settings& settings) {
  RowMaker maker;
  visit(settings, maker);
  return std::move(maker.rows);
}

}  // namespace sleight::config
