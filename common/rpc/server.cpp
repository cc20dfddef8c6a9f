#include "common/rpc/server.h"

#include <capnp/rpc-twoparty.h>
#include <kj/async-io.h>
#include <kj/debug.h>

#include <algorithm>
#include <unordered_set>
#include <utility>

#include "common/base/check.h"
#include "common/base/error.h"
#include "common/rpc/from_now.h"
#include "common/rpc/guarded_messages.h"
#include "common/rpc/loop_impl.h"
#include "common/rpc/service_calls.h"
#include "common/rpc/unix_socket.h"
#include "common/rpc/watchers.h"

namespace sleight::rpc {
namespace {

constexpr double k_look_s = 0.25;          // between looks at what connections hold, and how long
constexpr double k_accept_again_s = 0.25;  // after a failure, such as too many open files

double seconds(kj::Duration duration) {
  return static_cast<double>(duration / kj::MICROSECONDS) * 1e-6;
}

capnp::ReaderOptions reader_options(const ServerLimits& limits) {
  capnp::ReaderOptions options;
  // Messages have a size of their own; this bounds what a message can claim to hold by pointing at
  // the same words again and again.
  options.traversalLimitInWords = 2 * limits.message_bytes_max / sizeof(capnp::word);
  options.nestingLimit = k_nesting_max;
  return options;
}

}  // namespace

struct Server::Impl final : kj::TaskSet::ErrorHandler {
  struct Connection;

  Impl(Loop& loop, const std::string& path, Handler& handler, const ServerLimits& wanted,
       Complain complain_to, std::optional<std::uint32_t> group);
  ~Impl();
  KJ_DISALLOW_COPY(Impl);

  void accept_next();
  void admit(kj::Own<kj::AsyncIoStream> stream);
  bool make_room();
  void serve(kj::Own<kj::AsyncIoStream> stream, const Peer& peer);
  void bound_what_is_held();
  void look();
  void taskFailed(kj::Exception&& exception) override;

  kj::Timer& timer;
  kj::LowLevelAsyncIoProvider& provider;
  ServerLimits limits;
  Complain complain;
  ListeningSocket socket;
  kj::Own<kj::ConnectionReceiver> receiver;
  std::shared_ptr<Calls> calls = std::make_shared<Calls>();
  Watchers watchers;
  std::unordered_set<Connection*> connections;  ///< each is owned by its task
  std::uint64_t accepted = 0;
  std::uint64_t ended = 0;
  bool accept_fails = false;  ///< said once
  Loop::Handle looking;
  kj::TaskSet tasks;  ///< the last one: it looks at what stands above
};

struct Server::Impl::Connection {
  Connection(Impl& server_impl, kj::Own<kj::AsyncIoStream> connected, const Peer& peer)
      : server(server_impl),
        stream(kj::mv(connected)),
        messages(*stream, server.timer, traffic, server.limits.message_bytes_max,
                 [this] { server.bound_what_is_held(); }),
        network(messages, capnp::rpc::twoparty::Side::SERVER, reader_options(server.limits)),
        system(capnp::makeRpcServer(network, make_entrance(server.calls, conversation))) {
    conversation->caller = {.user = peer.user, .pid = peer.pid};
    system.setFlowLimit(server.limits.message_bytes_max / sizeof(capnp::word));
    server.connections.insert(this);
  }
  ~Connection() { server.connections.erase(this); }
  KJ_DISALLOW_COPY(Connection);

  std::size_t held_bytes() { return traffic.incoming_bytes + network.getCurrentQueueSize(); }
  bool is_idle() const {
    return conversation->calls == 0 && traffic.writes == 0 && traffic.incoming_bytes == 0;
  }
  /// For how long it has kept a message or an answer on its way, or else been idle.
  double waiting_s(kj::TimePoint now) const {
    kj::TimePoint since = now;
    if (traffic.incoming_bytes > 0) since = kj::min(since, traffic.incoming_since);
    if (traffic.writes > 0) since = kj::min(since, traffic.writing_since);
    if (is_idle()) since = traffic.active;
    return seconds(now - since);
  }
  /// It is gone in a later turn of the loop.
  void end() {
    if (std::exchange(is_ending, true)) return;
    ++server.ended;
    ender.fulfiller->fulfill();
  }

  Impl& server;
  bool is_ending = false;
  kj::PromiseFulfillerPair<void> ender = kj::newPromiseAndFulfiller<void>();
  std::shared_ptr<Conversation> conversation = std::make_shared<Conversation>();
  Traffic traffic;
  kj::Own<kj::AsyncIoStream> stream;
  GuardedMessages messages;
  capnp::TwoPartyVatNetwork network;
  capnp::RpcSystem<capnp::rpc::twoparty::VatId> system;
};

Server::Impl::Impl(Loop& loop, const std::string& path, Handler& handler,
                   const ServerLimits& wanted, Complain complain_to,
                   std::optional<std::uint32_t> group)
    : timer(loop.impl().timer()),
      provider(*loop.impl().io.lowLevelProvider),
      limits(wanted),
      complain(complain_to ? std::move(complain_to) : [](const std::string&) {}),
      socket(path, group),
      receiver(provider.wrapListenSocketFd(socket.descriptor(),
                                           kj::LowLevelAsyncIoProvider::ALREADY_CLOEXEC |
                                               kj::LowLevelAsyncIoProvider::ALREADY_NONBLOCK)),
      watchers(handler, timer, limits.watch_s_max, complain),
      tasks(*this) {
  *calls = {.handler = &handler,
            .watchers = &watchers,
            .limits = limits,
            .complain = complain,
            .connections = [this] { return connections.size(); }};
  looking = loop.call_every(k_look_s, [this] { look(); });
  accept_next();
}

Server::Impl::~Impl() {
  calls->handler = nullptr;
}

// ---------------------------------------------------------------------------- admitting
// connections

void Server::Impl::accept_next() {
  tasks.add(receiver->accept().then(
      [this](kj::Own<kj::AsyncIoStream> stream) {
        accept_fails = false;
        admit(kj::mv(stream));
        accept_next();
      },
      [this](kj::Exception&& exception) {
        if (!std::exchange(accept_fails, true)) {
          complain(std::string("no connection can be accepted: ") +
                   exception.getDescription().cStr());
        }
        make_room();
        tasks.add(timer.atTime(from_now(k_accept_again_s)).then([this] { accept_next(); }));
      }));
}

void Server::Impl::admit(kj::Own<kj::AsyncIoStream> stream) {
  const std::size_t ending = static_cast<std::size_t>(
      std::count_if(connections.begin(), connections.end(),
                    [](const Connection* connection) { return connection->is_ending; }));
  if (connections.size() - ending >= limits.connections_max && !make_room()) {
    ++ended;
    return;
  }
  KJ_IF_MAYBE (descriptor, stream->getFd()) {
    try {
      const Peer peer = peer_of(*descriptor);
      serve(kj::mv(stream), peer);
    } catch (const base::Error& error) {
      complain(error.what());
    }
  }
}

/// Ends the connection that has been idle longest, if any has been for long enough.
bool Server::Impl::make_room() {
  const kj::TimePoint now = timer.now();
  Connection* longest = nullptr;
  for (Connection* connection : connections) {
    if (connection->is_ending || !connection->is_idle()) continue;
    if (longest == nullptr || connection->traffic.active < longest->traffic.active)
      longest = connection;
  }
  if (longest == nullptr || longest->waiting_s(now) < limits.idle_grace_s) return false;
  longest->end();
  return true;
}

void Server::Impl::serve(kj::Own<kj::AsyncIoStream> stream, const Peer& peer) {
  auto connection = kj::heap<Connection>(*this, kj::mv(stream), peer);
  ++accepted;
  auto over = connection->network.onDisconnect().exclusiveJoin(kj::mv(connection->ender.promise));
  tasks.add(over.attach(kj::mv(connection)));
}

// ------------------------------------------------------------------------------ what connections
// hold

void Server::Impl::bound_what_is_held() {
  const kj::TimePoint now = timer.now();
  while (true) {
    std::size_t held = 0;
    Connection* longest = nullptr;
    for (Connection* connection : connections) {
      const std::size_t bytes = connection->held_bytes();
      if (connection->is_ending || bytes == 0) continue;
      held += bytes;
      if (longest == nullptr || connection->waiting_s(now) > longest->waiting_s(now))
        longest = connection;
    }
    if (held <= limits.held_bytes_max || longest == nullptr) return;
    longest->end();
  }
}

void Server::Impl::look() {
  const kj::TimePoint now = timer.now();
  for (Connection* connection : connections) {
    if (!connection->is_idle() && connection->waiting_s(now) > limits.message_s_max)
      connection->end();
  }
  bound_what_is_held();
}

// A connection that breaks is no failure of ours.
void Server::Impl::taskFailed(kj::Exception&& exception) {
  if (exception.getType() != kj::Exception::Type::DISCONNECTED)
    complain(std::string("a connection ended: ") + exception.getDescription().cStr());
}

Server::Server(Loop& loop, const std::string& socket_path, Handler& handler, ServerLimits limits,
               Complain complain, std::optional<std::uint32_t> group)
    : impl_(
          std::make_unique<Impl>(loop, socket_path, handler, limits, std::move(complain), group)) {}

Server::~Server() = default;

void Server::news(JobId job) {
  impl_->watchers.news(job);
}

ServerCounts Server::counts() const {
  ServerCounts counts = {.connections = impl_->connections.size(),
                         .watchers = impl_->watchers.waiting(),
                         .held_bytes = 0,
                         .accepted = impl_->accepted,
                         .ended = impl_->ended,
                         .calls = impl_->calls->count};
  for (Impl::Connection* connection : impl_->connections)
    counts.held_bytes += connection->held_bytes();
  return counts;
}

}  // namespace sleight::rpc
