#include "common/rpc/server.h"

#include <capnp/rpc-twoparty.h>
#include <kj/async-io.h>
#include <kj/compat/tls.h>
#include <kj/debug.h>
#include <malloc.h>

#include <algorithm>
#include <unordered_set>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "common/base/descriptor.h"
#include "common/base/error.h"
#include "common/rpc/from_now.h"
#include "common/rpc/guarded_messages.h"
#include "common/rpc/loop_impl.h"
#include "common/rpc/service_calls.h"
#include "common/rpc/tcp_socket.h"
#include "common/rpc/unix_socket.h"
#include "common/rpc/watchers.h"

namespace sleight::rpc {
namespace {

constexpr double k_look_s = 0.25;  // between checks of what connections hold and for how long
constexpr double k_accept_again_s = 0.25;  // delay after a failure, such as too many open files

double seconds(kj::Duration duration) {
  return static_cast<double>(duration / kj::MICROSECONDS) * 1e-6;
}

capnp::ReaderOptions reader_options(const ServerLimits& limits) {
  capnp::ReaderOptions options;
  // A message can claim to have more data than its size, by pointing to the same words repeatedly.
  // The traversal limit bounds such data.
  options.traversalLimitInWords = 2 * limits.message_bytes_max / sizeof(capnp::word);
  options.nestingLimit = k_nesting_max;
  return options;
}

}  // namespace

struct Server::Impl final : kj::TaskSet::ErrorHandler {
  struct Guest;
  struct Connection;
  struct Handshake;
  struct TlsDoor;

  Impl(Loop& loop, const std::string& path, Handler& handler, ServerOptions options);
  ~Impl();
  KJ_DISALLOW_COPY(Impl);

  using Admit = void (Impl::*)(kj::Own<kj::AsyncIoStream>);
  void accept_next(kj::ConnectionReceiver& from, Admit admit);
  void admit(kj::Own<kj::AsyncIoStream> stream);
  void admit_stranger(kj::Own<kj::AsyncIoStream> stream);
  bool make_room();
  bool make_room_for_stranger();
  std::vector<Guest*> strangers() const;
  void serve(kj::Own<kj::AsyncIoStream> stream, Caller caller, bool is_known);
  void bound_what_is_held();
  void look();
  void taskFailed(kj::Exception&& exception) override;

  kj::Timer& timer;
  kj::LowLevelAsyncIoProvider& provider;
  ServerLimits limits;
  std::function<void(const std::string&)> complain;
  ListeningSocket socket;
  kj::Own<kj::ConnectionReceiver> receiver;
  std::shared_ptr<Calls> calls = std::make_shared<Calls>();
  Watchers watchers;
  std::unordered_set<Connection*> connections;  ///< each owned by its task
  std::unordered_set<Handshake*> handshakes;    ///< each owned by its task
  std::unique_ptr<TlsDoor> tls;
  std::uint64_t accepted = 0;
  std::uint64_t ended = 0;
  bool accept_fails = false;  ///< already reported
  Loop::Handle looking;
  kj::TaskSet tasks;  ///< last member: its tasks use the members above
};

/// A connection or handshake that the server can end.
struct Server::Impl::Guest {
  explicit Guest(Impl& server_impl) : server(server_impl), began(server.timer.now()) {}
  KJ_DISALLOW_COPY(Guest);
  /// Ends the connection in a later turn of the loop.
  void end() {
    if (std::exchange(is_ending, true)) return;
    ++server.ended;
    ender.fulfiller->fulfill();
  }

  Impl& server;
  kj::TimePoint began;
  bool is_ending = false;
  kj::PromiseFulfillerPair<void> ender = kj::newPromiseAndFulfiller<void>();
};

struct Server::Impl::Connection : Guest {
  Connection(Impl& server_impl, kj::Own<kj::AsyncIoStream> connected, Caller caller, bool is_known)
      : Guest(server_impl),
        traffic{.message_bytes_max =
                    is_known ? server.limits.message_bytes_max : server.limits.stranger_bytes_max},
        stream(kj::mv(connected)),
        messages(*stream, server.timer, traffic, [this] { server.bound_what_is_held(); }),
        network(messages, capnp::rpc::twoparty::Side::SERVER, reader_options(server.limits)),
        system(capnp::makeRpcServer(network, make_entrance(server.calls, conversation))) {
    conversation->caller = std::move(caller);
    conversation->is_known = is_known;
    conversation->known = [this] { traffic.message_bytes_max = server.limits.message_bytes_max; };
    system.setFlowLimit(server.limits.message_bytes_max / sizeof(capnp::word));
    server.connections.insert(this);
  }
  ~Connection() {
    conversation->known = nullptr;  // a running call may still hold the conversation
    server.connections.erase(this);
  }

  std::size_t held_bytes() { return traffic.incoming_bytes + network.getCurrentQueueSize(); }
  bool is_stranger() const { return !conversation->is_known; }
  bool is_idle() const {
    return conversation->calls == 0 && traffic.writes == 0 && traffic.incoming_bytes == 0;
  }
  /// Returns how long a message or an answer has been in transit. If nothing is in transit, returns
  /// how long the connection has been idle.
  double waiting_s(kj::TimePoint now) const {
    kj::TimePoint since = now;
    if (traffic.incoming_bytes > 0) since = kj::min(since, traffic.incoming_since);
    if (traffic.writes > 0) since = kj::min(since, traffic.writing_since);
    if (is_idle()) since = traffic.active;
    return seconds(now - since);
  }

  std::shared_ptr<Conversation> conversation = std::make_shared<Conversation>();
  Traffic traffic;
  kj::Own<kj::AsyncIoStream> stream;
  GuardedMessages messages;
  capnp::TwoPartyVatNetwork network;
  capnp::RpcSystem<capnp::rpc::twoparty::VatId> system;
};

/// A new TCP peer, which may not even speak TLS.
struct Server::Impl::Handshake : Guest {
  explicit Handshake(Impl& server_impl) : Guest(server_impl) { server.handshakes.insert(this); }
  ~Handshake() { server.handshakes.erase(this); }
};

namespace {

kj::TlsContext::Options tls_options(const kj::TlsKeypair& keypair) {
  kj::TlsContext::Options options;
  options.useSystemTrustStore = false;
  options.minVersion = kj::TlsVersion::TLS_1_2;
  options.defaultKeypair = keypair;
  return options;
}

}  // namespace

struct Server::Impl::TlsDoor {
  TlsDoor(Impl& server, base::Descriptor listening, const access::Keypair& texts,
          Authority& lets_in)
      : authority(lets_in),
        descriptor(kj::mv(listening)),
        keypair{kj::TlsPrivateKey(kj::StringPtr(texts.key.c_str())),
                kj::TlsCertificate(kj::StringPtr(texts.certificate.c_str()))},
        context(tls_options(keypair)),
        receiver(server.provider.wrapListenSocketFd(
            descriptor.get(), kj::LowLevelAsyncIoProvider::ALREADY_CLOEXEC |
                                  kj::LowLevelAsyncIoProvider::ALREADY_NONBLOCK)) {}

  Authority& authority;
  base::Descriptor descriptor;
  kj::TlsKeypair keypair;
  kj::TlsContext context;
  kj::Own<kj::ConnectionReceiver> receiver;
};

Server::Impl::Impl(Loop& loop, const std::string& path, Handler& handler, ServerOptions options)
    : timer(loop.impl().timer()),
      provider(*loop.impl().io.lowLevelProvider),
      limits(options.limits),
      complain(options.complain ? std::move(options.complain) : [](const std::string&) {}),
      socket(path, options.group),
      receiver(provider.wrapListenSocketFd(socket.descriptor(),
                                           kj::LowLevelAsyncIoProvider::ALREADY_CLOEXEC |
                                               kj::LowLevelAsyncIoProvider::ALREADY_NONBLOCK)),
      watchers(handler, timer, limits.watch_s_max, complain),
      tasks(*this) {
  *calls = {.handler = &handler,
            .watchers = &watchers,
            .limits = limits,
            .complain = complain,
            .audit = std::move(options.audit),
            .connections = [this] { return connections.size(); }};
  looking = loop.call_every(k_look_s, [this] { look(); });
  accept_next(*receiver, &Impl::admit);
}

Server::Impl::~Impl() {
  calls->handler = nullptr;
}

// ------------------------------------------------------------------------ admitting connections

void Server::Impl::accept_next(kj::ConnectionReceiver& from, Admit let_in) {
  tasks.add(from.accept().then(
      [this, &from, let_in](kj::Own<kj::AsyncIoStream> stream) {
        accept_fails = false;
        (this->*let_in)(kj::mv(stream));
        accept_next(from, let_in);
      },
      [this, &from, let_in](kj::Exception&& exception) {
        if (!std::exchange(accept_fails, true)) {
          complain(std::string("can't accept connections: ") + exception.getDescription().cStr());
        }
        make_room_for_stranger();
        make_room();
        tasks.add(timer.atTime(from_now(k_accept_again_s)).then([this, &from, let_in] {
          accept_next(from, let_in);
        }));
      }));
}

void Server::Impl::admit(kj::Own<kj::AsyncIoStream> stream) {
  const auto staying = static_cast<std::size_t>(
      std::count_if(connections.begin(), connections.end(), [](const Connection* connection) {
        return !connection->is_ending && !connection->is_stranger();
      }));
  if (staying >= limits.connections_max && !make_room()) {
    ++ended;
    return;
  }
  KJ_IF_MAYBE (descriptor, stream->getFd()) {
    try {
      const Peer peer = peer_of(*descriptor);
      serve(kj::mv(stream), {.user = peer.user, .pid = peer.pid}, true);
    } catch (const base::Error& error) {
      complain(error.what());
    }
  }
}

/// Ends the connection that has been idle longest, if it has been idle for `idle_grace_s`.
bool Server::Impl::make_room() {
  const kj::TimePoint now = timer.now();
  Connection* longest = nullptr;
  for (Connection* connection : connections) {
    if (connection->is_ending || connection->is_stranger() || !connection->is_idle()) continue;
    if (longest == nullptr || connection->traffic.active < longest->traffic.active)
      longest = connection;
  }
  if (longest == nullptr || longest->waiting_s(now) < limits.idle_grace_s) return false;
  longest->end();
  return true;
}

/// Returns all strangers except those whose connection is ending.
std::vector<Server::Impl::Guest*> Server::Impl::strangers() const {
  std::vector<Guest*> found;
  for (Handshake* handshake : handshakes)
    if (!handshake->is_ending) found.push_back(handshake);
  for (Connection* connection : connections)
    if (!connection->is_ending && connection->is_stranger()) found.push_back(connection);
  return found;
}

/// Ends the oldest stranger, if it connected at least `idle_grace_s` ago.
bool Server::Impl::make_room_for_stranger() {
  const std::vector<Guest*> all = strangers();
  const auto longest = std::ranges::min_element(all, {}, &Guest::began);
  if (longest == all.end() || seconds(timer.now() - (*longest)->began) < limits.idle_grace_s)
    return false;
  (*longest)->end();
  return true;
}

void Server::Impl::admit_stranger(kj::Own<kj::AsyncIoStream> stream) {
  if (strangers().size() >= limits.strangers_max && !make_room_for_stranger()) {
    ++ended;
    return;
  }
  Caller caller;
  KJ_IF_MAYBE (descriptor, stream->getFd()) {
    tune(*descriptor);
    caller.address = peer_address_of(*descriptor);
  }
  auto handshake = kj::heap<Handshake>(*this);
  auto over = tls->context.wrapServer(kj::mv(stream))
                  .then([this, caller = std::move(caller)](kj::Own<kj::AsyncIoStream> secured) {
                    serve(kj::mv(secured), caller, false);
                  })
                  .exclusiveJoin(kj::mv(handshake->ender.promise))
                  // A stranger may send anything, so a failed handshake is not reported.
                  .catch_([](kj::Exception&&) {});
  tasks.add(over.attach(kj::mv(handshake)));
}

void Server::Impl::serve(kj::Own<kj::AsyncIoStream> stream, Caller caller, bool is_known) {
  auto connection = kj::heap<Connection>(*this, kj::mv(stream), std::move(caller), is_known);
  ++accepted;
  const bool is_tls = !connection->conversation->caller.address.empty();
  auto over = connection->network.onDisconnect().exclusiveJoin(kj::mv(connection->ender.promise));
  // A peer may break off its connection; TLS then reports a protocol failure.
  if (is_tls) over = over.catch_([](kj::Exception&&) {});
  tasks.add(over.attach(kj::mv(connection)));
}

// ----------------------------------------------------------------------- what connections hold

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
    const Conversation& conversation = *connection->conversation;
    const bool is_late =
        connection->is_stranger()
            ? conversation.has_failed || seconds(now - connection->began) > limits.login_s_max
            : !connection->is_idle() && connection->waiting_s(now) > limits.message_s_max;
    const bool is_out = !connection->is_stranger() && tls &&
                        !conversation.caller.token_id.empty() &&
                        !tls->authority.lets_go_on(conversation.caller);
    if (is_late || is_out) connection->end();
  }
  for (Handshake* handshake : handshakes)
    if (seconds(now - handshake->began) > limits.login_s_max) handshake->end();
  bound_what_is_held();
}

// A broken connection is not a failure of the server.
void Server::Impl::taskFailed(kj::Exception&& exception) {
  if (exception.getType() != kj::Exception::Type::DISCONNECTED)
    complain(std::string("a connection failed: ") + exception.getDescription().cStr());
}

Server::Server(Loop& loop, const std::string& socket_path, Handler& handler, ServerOptions options)
    : impl_(std::make_unique<Impl>(loop, socket_path, handler, std::move(options))) {
  // Return large blocks to the system when they are freed. By default glibc raises the mmap
  // threshold and keeps freed large blocks. A file's piece is copied into a message, and the
  // piece's freed block is slightly too small for another message. So memory would exceed the bound
  // of server.h.
  ::mallopt(M_MMAP_THRESHOLD, 256 << 10);
}

Server::~Server() = default;

access::ServerAddress Server::listen(const access::ServerAddress& address,
                                     const access::Keypair& keypair, Authority& authority) {
  CHECK(impl_->tls == nullptr);
  access::check_keypair(keypair);
  base::Descriptor socket = listen_at(address);
  const access::ServerAddress bound = own_address_of(socket.get());
  impl_->tls = std::make_unique<Impl::TlsDoor>(*impl_, std::move(socket), keypair, authority);
  impl_->calls->authority = &authority;
  impl_->accept_next(*impl_->tls->receiver, &Impl::admit_stranger);
  return {.host = address.host, .port = bound.port};
}

void Server::news(JobId job) {
  impl_->watchers.news(job);
}

ServerCounts Server::counts() const {
  ServerCounts counts = {.connections = impl_->connections.size(),
                         .watchers = impl_->watchers.waiting(),
                         .held_bytes = 0,
                         .strangers = impl_->strangers().size(),
                         .accepted = impl_->accepted,
                         .ended = impl_->ended,
                         .calls = impl_->calls->count};
  for (Impl::Connection* connection : impl_->connections)
    counts.held_bytes += connection->held_bytes();
  return counts;
}

}  // namespace sleight::rpc
