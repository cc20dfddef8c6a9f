#include "service/daemon/tls_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "common/base/descriptor.h"
#include "common/base/error.h"
#include "common/base/file_system.h"

namespace sleight::daemon {
namespace {

constexpr std::size_t k_pem_bytes_max = std::size_t{1} << 20U;

/// A secret that others can read is none.
void refuse_if_others_read(const std::string& path) {
  struct stat seen = {};
  if (::stat(path.c_str(), &seen) != 0 || (seen.st_mode & (S_IRWXG | S_IRWXO)) == 0) return;
  // A group that has the key for its services, as Debian's ssl-cert.
  const bool is_group_reader = (seen.st_mode & S_IRWXO) == 0 && (seen.st_mode & S_IWGRP) == 0;
  if (is_group_reader && seen.st_uid != ::geteuid()) return;
  throw base::Error(
      base::ExitCode::usage,
      fmt::format("{}: others than its owner can read this key; `chmod 600` it", path));
}

access::Keypair checked(access::Keypair keypair, const std::string& certificate_path) {
  try {
    access::check_keypair(keypair);
  } catch (const base::Error& failure) {
    throw base::Error(base::ExitCode::usage,
                      fmt::format("{}: {}", certificate_path, failure.what()));
  }
  return keypair;
}

/// For its owner alone from the first byte on.
void write_secret(base::FileSystem& files, const std::string& path, const std::string& text) {
  const std::string beside = path + ".new";
  static_cast<void>(::unlink(beside.c_str()));
  const base::Descriptor made(
      ::open(beside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (!made) {
    throw base::Error(
        fmt::format("{}: can't write it: {}", beside, std::system_category().message(errno)));
  }
  base::write_text_file(files, beside, text);
  files.sync_file(beside);
  files.rename(beside, path);
  files.sync_directory_of(path);
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
    const access::Keypair made = access::make_self_signed();
    files.make_folder(folder);
    // The key first: with the certificate both are there.
    write_secret(files, key, made.key);
    write_secret(files, certificate, made.certificate);
    return made;
  }
  refuse_if_others_read(key);
  return checked({.certificate = base::read_text_file(certificate, k_pem_bytes_max),
                  .key = base::read_text_file(key, k_pem_bytes_max)},
                 certificate);
}

}  // namespace sleight::daemon
