#include "service/daemon/tls_files.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/base/error.h"
#include "common/base/file_system.h"
#include "common/base/replaced_file.h"
#include "common/logging/log.h"

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

}  // namespace

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

}  // namespace sleight::daemon
