#include "clients/service_client/known_servers.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>

#include "common/base/error.h"
#include "common/base/file_system.h"
#include "common/base/own_folder.h"
#include "common/base/replaced_file.h"
#include "common/json/value.h"

namespace sleight::service_client {
namespace {

constexpr std::size_t k_known_file_bytes_max = std::size_t{1} << 20U;

std::string file_of_server(const access::ServerAddress& address) {
  const auto folder = base::own_folder("XDG_CONFIG_HOME", ".config", "servers");
  if (!folder) throw base::Error("no folder for stored logins: set HOME or XDG_CONFIG_HOME");
  return (*folder / (access::text_of(address) + ".json")).string();
}

[[noreturn]] void fail_at(const std::string& path) {
  throw base::Error(fmt::format("{}: {}", path, std::system_category().message(errno)));
}

rpc::RemoteService read_known(const access::ServerAddress& address) {
  const std::string path = file_of_server(address);
  struct stat seen = {};
  if (::stat(path.c_str(), &seen) != 0) {
    if (errno != ENOENT && errno != ENOTDIR) fail_at(path);
    throw base::Error(base::ExitCode::usage,
                      fmt::format("not logged in to {0}: run `sleight token create` on that "
                                  "machine, then `sleight login {0}` with the token",
                                  access::text_of(address)));
  }
  if ((seen.st_mode & (S_IRWXG | S_IRWXO)) != 0) {
    throw base::Error(fmt::format(
        "{}: other users can read this token; revoke the token, and log in with a new token",
        path));
  }
  try {
    const auto json = json::Value::parse(base::read_text_file(path, k_known_file_bytes_max));
    return {.address = address,
            .token = json.at("token").text(),
            .certificate = json.at("certificate").text(),
            .own_name = json.at("own_name").text()};
  } catch (const json::Error&) {
    throw base::Error(fmt::format("{}: not a valid login file; run `sleight login {}` again", path,
                                  access::text_of(address)));
  }
}

}  // namespace

rpc::ServicePlace place_of(const std::string& called) {
  if (called.starts_with('/')) return called;
  const auto address = access::server_address_of(called);
  if (!address)
    throw base::Error(
        base::ExitCode::usage,
        fmt::format("{}: expected the path of a socket, or HOST:PORT", terminal::shown(called)));
  return read_known(*address);
}

std::string remember(const rpc::RemoteService& service) {
  const std::string path = file_of_server(service.address);
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed || ::chmod(folder.c_str(), S_IRWXU) != 0) fail_at(folder.string());
  const json::Value json{{"server", access::text_of(service.address)},
                         {"token", service.token},
                         {"certificate", service.certificate},
                         {"own_name", service.own_name}};
  base::PosixFileSystem files;
  base::replace_text_file(files, path, json.dump(1) + "\n", base::Readers::owner);
  return path;
}

bool forget(const access::ServerAddress& address) {
  const std::string path = file_of_server(address);
  if (::unlink(path.c_str()) == 0) return true;
  if (errno == ENOENT || errno == ENOTDIR) return false;
  fail_at(path);
}

}  // namespace sleight::service_client
