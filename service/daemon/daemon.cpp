#include "service/daemon/daemon.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>

#include "common/access/certificates.h"
#include "common/access/token_text.h"
#include "common/base/clock.h"
#include "common/base/error.h"
#include "common/base/file_system.h"
#include "common/base/replaced_file.h"
#include "common/logging/log.h"
#include "common/rpc/server.h"
#include "common/store/run_lock.h"
#include "service/backend/backend.h"
#include "service/daemon/audit_log.h"
#include "service/daemon/tokens.h"

namespace sleight::daemon {
namespace {

constexpr std::size_t k_pem_bytes_max = std::size_t{1} << 20U;

/// Refuses a key file that others can read.
void refuse_if_others_read(const std::string& path) {
  struct stat seen = {};
  if (::stat(path.c_str(), &seen) != 0 || !S_ISREG(seen.st_mode))
    return;  // the later read reports the error
  if ((seen.st_mode & (S_IRWXG | S_IRWXO)) == 0) return;
  // Accept a group that exists for services' keys, such as Debian's ssl-cert.
  const bool is_group_reader = (seen.st_mode & S_IRWXO) == 0 && (seen.st_mode & S_IWGRP) == 0;
  if (is_group_reader && seen.st_uid != ::geteuid()) return;
  throw base::Error(
      base::ExitCode::usage,
      fmt::format("{}: other users can access this private key; run `chmod 600` on the file",
                  path));
}

access::Keypair checked(access::Keypair keypair, const std::string& certificate_path,
                        const std::string& key_path) {
  try {
    access::check_keypair(keypair);
  } catch (const base::Error& failure) {
    throw base::Error(base::ExitCode::usage,
                      fmt::format("{} with {}: {}", certificate_path, key_path, failure.what()));
  }
  if (!access::is_valid_now(keypair.certificate)) {
    logging::warn(
        fmt::format("{}: the certificate has expired or is not valid yet; clients will reject it",
                    certificate_path));
  }
  return keypair;
}

/// Reads certificate and key from the two paths. Without paths, reads `certificate.pem` and
/// `key.pem` in the state folder's `tls`. If these files are missing, creates them; only the owner
/// can read the key. Throws base::Error if a file can't be read, if others can read the key, or if
/// the key doesn't match the certificate. The error names the file.
access::Keypair keypair_of(const std::string& state, const std::string& certificate_path,
                           const std::string& key_path) {
  base::PosixFileSystem files;
  const bool is_own = certificate_path.empty();
  const std::string folder = state + "/tls";
  const std::string certificate = is_own ? folder + "/certificate.pem" : certificate_path;
  const std::string key = is_own ? folder + "/key.pem" : key_path;
  if (is_own && !(files.exists(certificate) && files.exists(key))) {
    if (files.exists(certificate)) {
      logging::warn(fmt::format(
          "{}: missing, so a new certificate and key are created; all clients must log in again",
          key));
    }
    const access::Keypair made = access::make_self_signed();
    files.make_folder(folder);
    // Write the key first. If the certificate exists, the key then also exists.
    base::replace_text_file(files, key, made.key, base::Readers::owner);
    base::replace_text_file(files, certificate, made.certificate);
    return made;
  }
  refuse_if_others_read(key);
  return checked({.certificate = base::read_text_file(certificate, k_pem_bytes_max),
                  .key = base::read_text_file(key, k_pem_bytes_max)},
                 certificate, key);
}

/// Locks the folder. If the lock is taken, throws base::Error(conflict) that names the other
/// process.
std::unique_ptr<store::RunLock> lock_state_folder(const std::string& state) {
  try {
    auto lock = std::make_unique<store::RunLock>(state);
    lock->keep();
    return lock;
  } catch (const base::Error& failure) {
    if (failure.exit_code() != base::ExitCode::conflict) throw;
    std::string process;
    std::ifstream(state + "/lock") >> process;
    throw base::Error(base::ExitCode::conflict,
                      fmt::format("{}: in use by another server{}; run `sleight server stop` to "
                                  "stop that server, or `sleight server status` to show its state",
                                  state, process.empty() ? "" : " (process " + process + ")"));
  }
}

/// Creates a folder that only its owner can read.
void make_state_folder(const std::string& state) {
  std::error_code reason;
  std::filesystem::create_directories(state, reason);
  if (reason || ::chmod(state.c_str(), 0700) != 0) {
    throw base::Error(fmt::format("{}: can't use the service's state folder: {}", state,
                                  reason ? reason.message() : std::strerror(errno)));
  }
}

/// Returns the state folder's name in batch systems. The first call draws the name at random.
std::string daemon_id_of(const std::string& state) {
  base::PosixFileSystem files;
  const std::string path = state + "/daemon.id";
  if (!files.exists(path)) {
    if (files.exists(state + "/jobs")) {
      logging::warn(
          fmt::format("{}: missing, so the daemon gets a new name and will not find batch jobs "
                      "that were submitted under its old name",
                      path));
    }
    base::replace_text_file(files, path, access::draw_token().id + "\n");
  }
  std::string id = base::read_text_file(path, 100);
  while (!id.empty() && id.back() == '\n')
    id.pop_back();
  if (backend::is_daemon_name(id)) return id;
  throw base::Error(
      fmt::format("{}: damaged; restore the file from a backup, because it contains the name that "
                  "identifies this service's batch jobs",
                  path));
}

}  // namespace

void run_daemon(const DaemonOptions& options) {
  make_state_folder(options.runner.state);
  const std::unique_ptr<store::RunLock> lock = lock_state_folder(options.runner.state);
  // If an object holds replies, the audit log must outlive it, because dropping a reply writes to
  // the log.
  base::SteadyClock clock;
  AuditLog audit(options.runner.state, clock);
  rpc::Loop loop;
  std::unique_ptr<rpc::Server> server;
  RunnerOptions runner_options = options.runner;
  if (runner_options.system) runner_options.daemon_id = daemon_id_of(options.runner.state);
  JobRunner runner(
      loop, runner_options,
      [&](jobs::JobId job) {
        if (server) server->news(rpc::JobId{job.value});
      },
      lock.get());
  base::PosixFileSystem files;
  Tokens tokens(files, options.runner.state + "/tokens.json", wall_s);
  Calls calls(loop, runner, tokens, options.facts, options.read, [&] { loop.stop(); });
  AuditedAuthority authority(tokens, audit);
  // Listen only after the jobs have been taken over.
  runner.begin();
  server = std::make_unique<rpc::Server>(
      loop, options.socket, calls,
      rpc::ServerOptions{
          .complain = [](const std::string& words) { logging::warn(words); },
          .group = options.group,
          .audit = [&audit](const rpc::Caller& caller,
                            const rpc::AuditLine& line) { audit.note(caller, line); }});
  if (options.address) {
    const access::Keypair keypair =
        keypair_of(options.runner.state, options.certificate_path, options.key_path);
    const std::string at = access::text_of(server->listen(*options.address, keypair, authority));
    const std::string fingerprint = access::fingerprint_of(keypair.certificate);
    calls.listens_at(at, fingerprint);
    logging::info(fmt::format("serving over TLS on {}, certificate {}", at, fingerprint));
  }
  const auto keeping = loop.call_every(k_token_uses_saved_s, [&] {
    tokens.save_uses();
    audit.flush();
  });
  loop.on_stop_signals([&](int) { loop.stop(); });
  logging::info(fmt::format("serving on {}, state in {}, process {}", options.socket,
                            options.runner.state, ::getpid()));
  loop.run();
  server.reset();
  tokens.save_uses();
  logging::info("server stopped; jobs keep running, and the next server takes them over");
}

}  // namespace sleight::daemon
