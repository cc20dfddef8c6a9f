#include "clients/web/server.h"

#include <fmt/format.h>
#include <netinet/in.h>
#include <pthread.h>
#include <sys/socket.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <exception>
#include <system_error>
#include <utility>

#include "clients/web/connection.h"
#include "clients/web/reply.h"
#include "clients/web/server_impl.h"
#include "common/base/check.h"
#include "common/base/error.h"
#include "common/base/memory.h"

namespace sleight::web {
namespace {

/// Memory for a thread's stack and first allocations.
constexpr std::size_t k_thread_bytes = std::size_t{16} << 20U;

namespace asio = boost::asio;
using asio::ip::tcp;
using SystemError = boost::system::error_code;

constexpr auto k_accept_again = std::chrono::milliseconds(250);  // after a failed accept
constexpr int k_accept_at_once = 16;      // connections accepted before others are served
constexpr std::size_t k_extras_max = 16;  // connections above the limit that receive a refusal
constexpr int k_send_buffer = 256 << 10;  // of the system; limits memory per slow reader
constexpr int k_waiting_max = 128;  // connections that the system queues before they are accepted

constexpr Refusal k_full{503, "This server has too many connections.",
                         "Close other windows of this page, and try again."};

std::string system_words(int number) {
  return std::generic_category().message(number);
}

/// A listening socket that isn't inherited by other processes, or the error.
struct Bound {
  base::Descriptor descriptor;
  int error = 0;
};

Bound bind_loopback(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  Bound bound;
  bound.descriptor.reset(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const int descriptor = bound.descriptor.get();
  const int yes = 1;
  // Makes the port usable right after a restart; two servers still cannot share it.
  const bool is_listening =
      descriptor >= 0 &&
      ::setsockopt(descriptor, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) == 0 &&
      ::bind(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
      ::listen(descriptor, k_waiting_max) == 0;
  if (!is_listening) {
    bound.error = errno;
    bound.descriptor.reset();
  }
  return bound;
}

std::uint16_t port_of(const base::Descriptor& descriptor) {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  CHECK_EQ(::getsockname(descriptor.get(), reinterpret_cast<sockaddr*>(&address), &size), 0);
  return ntohs(address.sin_port);
}

/// While this object exists, new threads receive no signals; the program's own threads handle them.
class WithoutSignals {
 public:
  WithoutSignals() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  ~WithoutSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  WithoutSignals(const WithoutSignals&) = delete;
  WithoutSignals& operator=(const WithoutSignals&) = delete;

 private:
  sigset_t before_{};
};

}  // namespace

Server::Impl::Listener::Listener(Impl& owner, base::Descriptor descriptor)
    : acceptor(owner.loop), again(owner.loop) {
  acceptor.assign(tcp::v4(), descriptor.release());
}

Server::Impl::Impl(ServerOptions wanted, Handler answering)
    : options(std::move(wanted)), handler(std::move(answering)), keys(options.secret) {
  const ServerLimits& limits = options.limits;
  CHECK_GE(limits.head_bytes_max, 4096U);
  CHECK_GT(options.threads, 0U);
  CHECK(handler != nullptr);
  bodies.bytes_max = limits.bodies_bytes_max;
  listen();
  guard = std::make_unique<Guard>(Guard::Options{.port = port,
                                                 .hosts = options.hosts,
                                                 .events_path = options.events_path,
                                                 .way_in = options.way_in},
                                  keys);
  newest_token = keys.new_token();
  accept_when_ready(*listener);
  comment_streams();
  const WithoutSignals guarded;
  // A thread pool that cannot create a thread waits for ever for its other threads.
  base::require_memory(options.threads * k_thread_bytes);
  pool = std::make_unique<asio::thread_pool>(options.threads);
  loop_thread = std::thread([this] { loop.run(); });
}

Server::Impl::~Impl() {
  stop();
}

void Server::Impl::listen() {
  Bound bound = bind_loopback(options.port);
  if (!bound.descriptor) {
    if (bound.error == EADDRINUSE) {
      throw base::Error(
          base::ExitCode::conflict,
          fmt::format("port {} is already in use; choose another port or omit the option",
                      options.port));
    }
    throw base::Error(
        fmt::format("cannot listen on 127.0.0.1:{}: {}", options.port, system_words(bound.error)));
  }
  port = port_of(bound.descriptor);
  listener = std::make_unique<Listener>(*this, std::move(bound.descriptor));
}

// --------------------------------------------------------------------------------- connections

void Server::Impl::accept_when_ready(Listener& from) {
  from.acceptor.async_wait(tcp::acceptor::wait_read, [this, &from](const SystemError& error) {
    if (!error) accept(from);
  });
}

void Server::Impl::accept(Listener& from) {
  // Calls accept4 directly: with Asio's accept, a fork in another thread could inherit the socket.
  for (int i = 0; i < k_accept_at_once; ++i) {
    base::Descriptor descriptor(
        ::accept4(from.acceptor.native_handle(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (descriptor) {
      from.fails = false;
      ++accepted;
      ::setsockopt(descriptor.get(), SOL_SOCKET, SO_SNDBUF, &k_send_buffer, sizeof k_send_buffer);
      tcp::socket socket(loop);
      SystemError failure;
      socket.assign(tcp::v4(), descriptor.get(), failure);
      if (failure) continue;
      descriptor.release();
      socket.set_option(tcp::no_delay(true), failure);
      admit(std::move(socket));
      continue;
    }
    if (errno == EINTR || errno == ECONNABORTED) continue;
    if (errno == EAGAIN || errno == EWOULDBLOCK) break;
    if (!std::exchange(from.fails, true))
      complain(fmt::format("cannot accept connections: {}", system_words(errno)));
    make_room();
    from.again.expires_after(k_accept_again);
    from.again.async_wait([this, &from](const SystemError& error) {
      if (!error) accept_when_ready(from);
    });
    return;
  }
  accept_when_ready(from);
}

void Server::Impl::admit(tcp::socket socket) {
  const auto extras = static_cast<std::size_t>(std::ranges::count_if(
      connections, [](const auto& entry) { return entry.second->is_extra(); }));
  const bool is_full =
      connections.size() - extras >= options.limits.connections_max && !make_room();
  if (is_full && extras >= k_extras_max) {
    ++closed;
    return;
  }
  const std::uint64_t number = accepted;
  const auto connection = std::make_shared<Connection>(*this, std::move(socket), number, is_full);
  connections.emplace(number, connection);
  connection_count = connections.size();
  if (is_full) {
    ++closed;
    connection->refuse(k_full);
  } else {
    connection->start();
  }
}

/// Closes the connection that has waited longest, if any may be closed.
bool Server::Impl::make_room() {
  const auto now = std::chrono::steady_clock::now();
  std::shared_ptr<Connection> longest;
  for (const auto& [number, connection] : connections) {
    if (connection->is_extra() || !connection->can_make_room()) continue;
    const std::chrono::duration<double> waited = now - connection->stage_since();
    if (waited.count() < options.limits.idle_grace_s) continue;
    if (!longest || connection->stage_since() < longest->stage_since()) longest = connection;
  }
  if (!longest) return false;
  longest->close_as_too_much();
  return true;
}

void Server::Impl::forget(const std::shared_ptr<Connection>& connection) {
  connections.erase(connection->number());
  connection_count = connections.size();
  streams.erase(connection->number());
  stream_count = streams.size();
}

void Server::Impl::bound_answers() {
  while (answers_bytes > options.limits.answers_bytes_max) {
    std::shared_ptr<Connection> longest;
    for (const auto& [number, connection] : connections) {
      if (!connection->is_writing()) continue;
      if (!longest || connection->stage_since() < longest->stage_since()) longest = connection;
    }
    if (!longest) return;
    longest->close_as_too_much();
  }
}

// ---------------------------------------------------------------------------------------- events

void Server::Impl::start_stream(const std::shared_ptr<Connection>& connection) {
  if (streams.size() >= options.limits.streams_max) {
    Refusal refusal = k_full;
    refusal.is_json = true;
    return connection->refuse(refusal);
  }
  streams.emplace(connection->number(), connection);
  stream_count = streams.size();
  connection->stream();
}

void Server::Impl::comment_streams() {
  comments.expires_after(std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(options.limits.stream_comment_s)));
  comments.async_wait([this](const SystemError& error) {
    if (error) return;
    const auto comment = std::make_shared<const std::string>(":\n\n");
    const auto now = streams;  // a push may close its stream
    for (const auto& [number, stream] : now)
      stream->push(comment);
    comment_streams();
  });
}

void Server::Impl::publish(const std::string& event, std::shared_ptr<const std::string> text) {
  const auto now = streams;
  for (const auto& [number, stream] : now)
    stream->push(text);
  newest_events[event] = std::move(text);
}

// --------------------------------------------------------------------------------------- answers

void Server::Impl::complain(const std::string& words) const {
  if (options.complain) options.complain(words);
}

Answer Server::Impl::answer(const Ask& ask) const {
  const auto failed = [&](const std::string& words) {
    complain(words);
    return error_answer(500, "The program failed to answer.",
                        "This is a bug: please report it with the program's terminal output.");
  };
  try {
    Answer answer = handler(ask);
    if (!is_sound(answer)) return failed("an answer has an invalid status or header");
    return answer;
  } catch (const std::exception& error) {
    return failed(fmt::format("failed to answer a request: {}", error.what()));
  } catch (...) {
    return failed("failed to answer a request");
  }
}

void Server::Impl::stop() {
  const std::lock_guard lock(stop_mutex);
  if (std::exchange(is_stopped, true)) return;
  loop.stop();
  if (loop_thread.joinable()) loop_thread.join();
  // Running handlers end first. Work that handlers post to the ended loop never runs.
  if (pool) {
    pool->stop();
    pool->join();
  }
  // The loop has ended, so this thread may access its data.
  listener.reset();
  const auto now = connections;
  for (const auto& [number, connection] : now)
    connection->close();
}

// ---------------------------------------------------------------------------------------- server

Server::Server(ServerOptions options, Handler handler)
    : impl_(std::make_unique<Impl>(std::move(options), std::move(handler))) {}

Server::~Server() = default;

std::uint16_t Server::port() const {
  return impl_->port;
}

std::string Server::link() const {
  const std::lock_guard lock(impl_->link_mutex);
  return fmt::format("http://127.0.0.1:{}/?token={}", impl_->port, impl_->newest_token);
}

std::string Server::new_link() {
  {
    const std::lock_guard lock(impl_->link_mutex);
    impl_->newest_token = impl_->keys.new_token();
  }
  return link();
}

void Server::publish(const std::string& event, const std::string& data) {
  auto text = std::make_shared<const std::string>(event_text(event, data));
  asio::post(impl_->loop, [impl = impl_.get(), event, text = std::move(text)]() mutable {
    impl->publish(event, std::move(text));
  });
}

void Server::stop() {
  impl_->stop();
}

ServerCounts Server::counts() const {
  return {.connections = impl_->connection_count,
          .streams = impl_->stream_count,
          .bodies_bytes = impl_->bodies.bytes,
          .answers_bytes = impl_->answers_bytes,
          .closed = impl_->closed,
          .asks = impl_->asks};
}

}  // namespace sleight::web
