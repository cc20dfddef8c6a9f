#include "common/rpc/tcp_socket.h"

#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <cerrno>
#include <memory>
#include <optional>
#include <system_error>

#include "common/base/error.h"

namespace sleight::rpc {
namespace {

constexpr int k_not_accepted_max = 1024;  // accept queue; the system may limit it further
constexpr int k_silent_s = 60;            // silence before the first keep-alive probe
constexpr int k_asked_s = 20;             // between keep-alive probes
constexpr int k_asked_times = 4;

void set(int descriptor, int level, int option, int value) {
  // Failure is harmless: without the option the connection is only slower.
  static_cast<void>(::setsockopt(descriptor, level, option, &value, sizeof value));
}

using GetName = int (*)(int, sockaddr*, socklen_t*);

std::optional<access::ServerAddress> name_by(GetName get_name, int descriptor) {
  sockaddr_storage address = {};
  socklen_t size = sizeof address;
  char host[NI_MAXHOST] = {};
  char port[NI_MAXSERV] = {};
  auto* as_address = reinterpret_cast<sockaddr*>(&address);
  if (get_name(descriptor, as_address, &size) != 0 ||
      ::getnameinfo(as_address, size, host, sizeof host, port, sizeof port,
                    NI_NUMERICHOST | NI_NUMERICSERV) != 0)
    return std::nullopt;
  return access::ServerAddress{.host = host, .port = static_cast<std::uint16_t>(std::atoi(port))};
}

}  // namespace

base::Descriptor listen_at(const access::ServerAddress& address) {
  addrinfo hints = {};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE;
  addrinfo* found = nullptr;
  const std::string port = std::to_string(address.port);
  const int failure = ::getaddrinfo(address.host.c_str(), port.c_str(), &hints, &found);
  if (failure != 0) {
    throw base::Error(fmt::format("the service can't listen at {}: {}", access::text_of(address),
                                  ::gai_strerror(failure)));
  }
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> held(found, &::freeaddrinfo);
  base::Descriptor socket(
      ::socket(found->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, found->ai_protocol));
  if (socket) set(socket.get(), SOL_SOCKET, SO_REUSEADDR, 1);
  if (!socket || ::bind(socket.get(), found->ai_addr, found->ai_addrlen) != 0 ||
      ::listen(socket.get(), k_not_accepted_max) != 0) {
    const int error = errno;
    throw base::Error(error == EADDRINUSE ? base::ExitCode::conflict : base::ExitCode::environment,
                      fmt::format("the service can't listen at {}: {}", access::text_of(address),
                                  std::system_category().message(error)));
  }
  return socket;
}

std::string peer_address_of(int descriptor) {
  const auto name = name_by(&::getpeername, descriptor);
  return name ? access::text_of(*name) : "?";
}

access::ServerAddress own_address_of(int descriptor) {
  const auto name = name_by(&::getsockname, descriptor);
  if (!name) throw base::Error("can't determine the address at which a socket listens");
  return *name;
}

void tune(int descriptor) {
  set(descriptor, IPPROTO_TCP, TCP_NODELAY, 1);
  set(descriptor, SOL_SOCKET, SO_KEEPALIVE, 1);
  set(descriptor, IPPROTO_TCP, TCP_KEEPIDLE, k_silent_s);
  set(descriptor, IPPROTO_TCP, TCP_KEEPINTVL, k_asked_s);
  set(descriptor, IPPROTO_TCP, TCP_KEEPCNT, k_asked_times);
}

}  // namespace sleight::rpc
