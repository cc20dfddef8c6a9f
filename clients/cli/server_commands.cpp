#include "clients/cli/server_commands.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <optional>
#include <thread>

#include "clients/cli/job_text.h"
#include "clients/cli/service_json.h"
#include "clients/service_client/known_servers.h"
#include "clients/service_client/server_process.h"
#include "clients/service_client/service_call.h"
#include "clients/terminal/output.h"
#include "common/base/clock.h"
#include "common/base/error.h"
#include "common/base/version.h"
#include "common/events/progress.h"
#include "common/rpc/client.h"

namespace sleight::cli {
namespace {

constexpr double k_start_s_max = 30;
constexpr double k_stop_s_max = 30;
constexpr std::chrono::milliseconds k_server_look_again{20};
/// Number of log lines that are shown if a daemon doesn't start.
constexpr std::size_t k_told_log_lines = 20;

/// Returns the daemon's status, or nothing if no daemon answers.
std::optional<rpc::ServerView> server_at(const std::string& socket) {
  try {
    rpc::Client client(service_client::place_of(socket), {.call_s_max = 5});
    return client.info();
  } catch (const rpc::NoServer&) {
    return std::nullopt;
  }
}

int tell_started(const rpc::ServerView& server, const std::string& socket, bool was_running,
                 const ServerStartOptions& options) {
  if (options.json) {
    fmt::print("{}\n", indented({{"pid", server.pid},
                                 {"socket", socket},
                                 {"state_folder", server.state_folder},
                                 {"already_running", was_running}}));
    return terminal::k_ok;
  }
  fmt::print("the server {}: pid {}, {}\n", was_running ? "is already running" : "is running",
             server.pid, terminal::shown(socket));
  if (was_running && !options.given.empty())
    terminal::complain(
        "the running server keeps its settings; to change settings, stop and start the server");
  return terminal::k_ok;
}

[[noreturn]] void fail_start(const service_client::ServerProcess& process,
                             const std::string& what) {
  std::string words = fmt::format("{}; the log is {}", what, terminal::shown(process.log_path()));
  for (const std::string& line : process.log_lines(k_told_log_lines))
    words += "\n  " + terminal::shown(line);
  throw base::Error(process.exit_code(), words);
}

/// Waits until the started daemon answers, or another daemon that started first.
int wait_for_server(service_client::ServerProcess& process, const std::string& socket,
                    const ServerStartOptions& options) {
  const base::SteadyClock clock;
  const double began_s = clock.now_s();
  while (true) {
    const bool runs = process.is_running();
    if (const auto server = server_at(socket))
      return tell_started(*server, socket, server->pid != process.pid(), options);
    if (!runs) fail_start(process, "sleightd exited immediately");
    if (clock.now_s() - began_s > k_start_s_max) {
      fail_start(process, fmt::format("sleightd (pid {}) does not answer after {} s", process.pid(),
                                      k_start_s_max));
    }
    std::this_thread::sleep_for(k_server_look_again);
  }
}

/// Whether the process is a zombie: exited, but not reaped.
bool has_exited(std::int64_t pid) {
  std::string line;
  std::ifstream file(fmt::format("/proc/{}/stat", pid));
  std::getline(file, line);
  const auto name_end = line.rfind(')');
  return name_end != std::string::npos && line.substr(name_end).starts_with(") Z");
}

/// Whether a daemon has exited. The daemon deletes its socket before it exits, but its folder is
/// free only after it has exited. A daemon on another machine counts as exited if it doesn't
/// answer.
bool is_gone(std::int64_t pid, const std::string& socket) {
  if (!socket.starts_with('/')) return !server_at(socket);
  if (pid > 0 && ::kill(static_cast<pid_t>(pid), 0) == 0) return has_exited(pid);
  if (pid > 0 && errno == ESRCH) return true;
  // Another user's process can't be signalled, so test the socket.
  return ::access(socket.c_str(), F_OK) != 0;
}

/// Returns the pid of a server that owns this socket's folder but doesn't answer. Either its socket
/// was deleted, or it is exiting. 0: none.
std::int64_t silent_server_at(const std::string& socket) {
  const config::Settings settings = config::settings_here({});
  if (settings.socket.value != socket) return 0;
  std::int64_t pid = 0;
  std::ifstream(settings.state.value + "/lock") >> pid;
  std::string name;
  std::ifstream(fmt::format("/proc/{}/comm", pid)) >> name;
  return pid > 0 && name == "sleightd" ? pid : 0;
}

void wait_until_gone(std::int64_t pid, const std::string& socket) {
  const base::SteadyClock clock;
  const double began_s = clock.now_s();
  while (!is_gone(pid, socket)) {
    if (clock.now_s() - began_s > k_stop_s_max) {
      throw base::Error(
          fmt::format("the server (pid {}) has not exited after {} s", pid, k_stop_s_max));
    }
    std::this_thread::sleep_for(k_server_look_again);
  }
}

int tell_stopped(std::int64_t pid, bool json) {
  if (json) {
    fmt::print("{}\n", indented({{"pid", pid}, {"stopped", true}}));
  } else {
    fmt::print(
        "the server (pid {}) has stopped; its jobs keep running, and the next server takes them "
        "over\n",
        pid);
  }
  return terminal::k_ok;
}

/// Converts "core-hours of a user" to the key core_hours_of_a_user.
std::string key_of(std::string words) {
  std::ranges::replace_if(
      words, [](char c) { return c == ' ' || c == '-' || c == ','; }, '_');
  return words;
}

std::string jobs_line(const rpc::ServerView& server) {
  std::vector<std::string> parts;
  for (const rpc::StateCount& count : server.counts) {
    if (count.count > 0)
      parts.push_back(
          fmt::format("{} {}", events::grouped(count.count), rpc::name_of(count.state)));
  }
  return parts.empty() ? "none" : fmt::format("{}", fmt::join(parts, ", "));
}

std::string limits_line(const rpc::ServerView& server) {
  std::vector<std::string> parts;
  for (const rpc::NamedLimit& limit : server.limits)
    parts.push_back(
        fmt::format("{} {}", terminal::shown(limit.name), terminal::shown(limit.value)));
  return fmt::format("{}", fmt::join(parts, ", "));
}

}  // namespace

std::vector<std::string> server_command(const std::string& program,
                                        const std::vector<config::Given>& given) {
  std::vector<std::string> command{program};
  for (const config::Given& one : given)
    command.push_back(one.given_by + "=" + one.text);
  return command;
}

report::Report server_report(const rpc::ServerView& server, const std::string& socket) {
  Json jobs = Json::object();
  for (const rpc::StateCount& count : server.counts)
    jobs[std::string(rpc::name_of(count.state))] = count.count;
  Json limits = Json::object();
  for (const rpc::NamedLimit& limit : server.limits)
    limits[key_of(limit.name)] = limit.value;
  std::string version = terminal::shown(server.version);
  if (server.version != base::version())
    version += fmt::format(" (this sleight is {})", base::version());
  report::Report report;
  report.for_people("server", fmt::format("pid {}, up {}, {}{}", server.pid,
                                          events::clock_time(server.up_s), terminal::shown(socket),
                                          server.draining ? "; draining: no more jobs start" : ""));
  report.for_programs("pid", server.pid);
  report.for_programs("up_seconds", server.up_s);
  report.for_programs("socket", socket);
  report.for_programs("draining", server.draining);
  report.add("version", server.version, "version",
             fmt::format("{}, results {}", version, terminal::shown(server.results_version)));
  report.for_programs("results_version", server.results_version);
  report.add("state_folder", server.state_folder, "state", terminal::shown(server.state_folder));
  report.add("jobs", std::move(jobs), "jobs", jobs_line(server));
  report.for_people("cores", fmt::format("{} of {} in use, backend {}", server.cores_used,
                                         server.cores, terminal::shown(server.backend)));
  report.for_programs("cores", server.cores);
  report.for_programs("cores_used", server.cores_used);
  report.for_programs("backend", server.backend);
  report.for_people("memory", fmt::format("{} of {} in use", size_text(server.memory_used_bytes),
                                          size_text(server.memory_bytes)));
  report.for_programs("memory_bytes", server.memory_bytes);
  report.for_programs("memory_used_bytes", server.memory_used_bytes);
  report.for_people(
      "disk", fmt::format("{} free, of which {} are reserved", size_text(server.disk_free_bytes),
                          size_text(server.disk_reserve_bytes)));
  report.for_programs("disk_free_bytes", server.disk_free_bytes);
  report.for_programs("disk_reserve_bytes", server.disk_reserve_bytes);
  report.add("keeping_rule", server.keeping_rule, "keeps", terminal::shown(server.keeping_rule));
  report.add("limits", std::move(limits), "limits", limits_line(server));
  const auto or_null = [](const std::string& text) { return text.empty() ? Json() : Json(text); };
  const bool listens = !server.address.empty();
  report.add("address", or_null(server.address), "listens",
             listens ? terminal::shown(server.address) + " over TLS" : "");
  report.add("fingerprint", or_null(server.fingerprint), "certificate",
             listens ? terminal::shown(server.fingerprint) : "");
  report.for_people("clients", fmt::format("{} connection{}, {} watching", server.connections,
                                           server.connections == 1 ? "" : "s", server.watchers));
  report.for_programs("connections", server.connections);
  report.for_programs("watchers", server.watchers);
  return report;
}

int start_server(const ServerStartOptions& options) {
  const config::Settings settings = config::settings_here(options.given);
  const std::string& socket = settings.socket.value;
  if (const auto server = server_at(socket)) return tell_started(*server, socket, true, options);
  const std::string program = service_client::program_beside("sleightd");
  const std::vector<std::string> command = server_command(program, options.given);
  if (options.foreground) service_client::become(command);
  service_client::ServerProcess process(command, settings.state.value);
  return wait_for_server(process, socket, options);
}

int stop_server(const std::string& socket, bool json) {
  const auto server = server_at(socket);
  if (!server) {
    if (const std::int64_t pid = silent_server_at(socket); pid > 0) {
      if (::kill(static_cast<pid_t>(pid), SIGTERM) != 0) {
        throw base::Error(base::ExitCode::not_allowed,
                          fmt::format("the server (pid {}) does not answer, and can't be stopped "
                                      "from here: {}",
                                      pid, std::strerror(errno)));
      }
      wait_until_gone(pid, socket);
      return tell_stopped(pid, json);
    }
    if (json) {
      fmt::print("{}\n", indented({{"pid", nullptr}, {"stopped", false}}));
    } else {
      fmt::print("no server is running at {}\n", terminal::shown(socket));
    }
    return terminal::k_ok;
  }
  return service_client::with_service(socket, [&](rpc::Client& client) {
    client.stop();
    wait_until_gone(server->pid, socket);
    return tell_stopped(server->pid, json);
  });
}

int drain_server(const std::string& socket, bool json) {
  return service_client::with_service(socket, [&](rpc::Client& client) {
    client.drain();
    const rpc::ServerView server = client.info();
    if (json) {
      fmt::print("{}\n", indented(server_report(server, socket).as_json()));
    } else {
      fmt::print(
          "the server starts no more jobs and stops all running jobs cleanly; to see which jobs "
          "remain, run `sleight server status`\n");
    }
    return terminal::k_ok;
  });
}

int show_server(const std::string& socket, bool json) {
  return service_client::with_service(socket, [&](rpc::Client& client) {
    const report::Report report = server_report(client.info(), socket);
    if (json) {
      fmt::print("{}\n", indented(report.as_json()));
    } else {
      fmt::print("{}", report.as_text(0, 12));
    }
    return terminal::k_ok;
  });
}

}  // namespace sleight::cli
