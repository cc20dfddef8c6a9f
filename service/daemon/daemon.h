// The daemon as a whole: a state folder that is its alone, the jobs in it, and the socket on which
// it answers.
//
//   state folder (0700)
//     lock          held as long as the daemon lives: one daemon a folder
//     socket        where it answers (0600); for a group's members (0660) it lies elsewhere
//     jobs.sqlite   the job store (job_store.h)
//     jobs/17/      a job's folder (job_folder.h, service/keeper)
//     server.log    what a daemon in the background says
//     audit.log     who did what (audit_log.h)
//     daemon.id     its name towards a batch system
//     tokens.json   by which peers over TCP are let in (tokens.h)
//     tls/          the certificate of its own making, if it listens over TCP without another
//
// Killed at any moment, it loses nothing that it has answered, and no job notices: the next one
// takes the jobs up where they are.
//
// Thread safety: run() is the thread's; signals end it in order.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/access/server_address.h"
#include "service/daemon/calls.h"
#include "service/daemon/job_runner.h"
#include "service/daemon/requests.h"

namespace sleight::daemon {

struct DaemonOptions {
  RunnerOptions runner{};
  std::string socket{};
  /// Whose members may call it too; none: its own user alone.
  std::optional<std::uint32_t> group{};
  /// Where it listens over TCP too; none: nowhere.
  std::optional<access::ServerAddress> address{};
  /// Certificate and key in PEM; empty: of its own making, in the state folder.
  std::string certificate_path{};
  std::string key_path{};
  ServerFacts facts{};
  ReadRequest read{};
};

/// Serves until it is stopped, by a call or by SIGTERM or SIGINT; jobs run on. Throws base::Error:
/// conflict where another daemon has the folder or the socket, environment where the folder can't
/// be used or the job store is damaged (job_store.h).
void run_daemon(const DaemonOptions& options);

}  // namespace sleight::daemon
