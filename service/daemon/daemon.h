// The whole daemon: its state folder, its jobs and its socket.
//
//   State folder (0700):
//     `lock`          is held while the daemon lives, so that a folder has only one daemon.
//     `socket`        is where the daemon answers (mode 0600). A socket for a group (mode 0660) is
//                     elsewhere.
//     `jobs.sqlite`   is the job store (job_store.h).
//     `jobs/17/`      is a job's folder (job_folder.h, service/keeper).
//     `server.log`    has the daemon's output if it runs in the background.
//     `audit.log`     records who did what (audit_log.h).
//     `daemon.id`     is the daemon's name in a batch system.
//     `tokens.json`   has the access tokens for TCP (tokens.h).
//     `tls/`          has a self-signed certificate for TCP, unless another certificate is
//                     configured.
//
// If the daemon is killed, no answered change is lost. The jobs continue, and the next daemon takes
// them over.
//
// Thread safety: run() belongs to one thread. SIGTERM and SIGINT end the daemon cleanly.
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
  /// Members of this group can also connect. None: only the daemon's own user can.
  std::optional<std::uint32_t> group{};
  /// Address to listen on over TCP. None: no TCP.
  std::optional<access::ServerAddress> address{};
  /// Certificate and key, in PEM. Empty: use a self-signed certificate in the state folder.
  std::string certificate_path{};
  std::string key_path{};
  ServerFacts facts{};
  ReadRequest read{};
};

/// Serves until a call, SIGTERM or SIGINT stops the daemon; jobs keep running. Throws
/// base::Error(conflict) if another daemon has the folder or the socket. Throws
/// base::Error(environment) if the folder is unusable or the job store is damaged (job_store.h).
void run_daemon(const DaemonOptions& options);

}  // namespace sleight::daemon
