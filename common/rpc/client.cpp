#include "common/rpc/client.h"

#include <capnp/rpc-twoparty.h>
#include <fmt/format.h>
#include <kj/async-io.h>
#include <kj/async-unix.h>
#include <kj/compat/tls.h>
#include <kj/debug.h>
#include <sys/random.h>
#include <unistd.h>

#include "common/access/certificates.h"
#include "common/base/check.h"
#include "common/base/clock.h"
#include "common/rpc/encoding.h"
#include "common/rpc/event_descriptor.h"
#include "common/rpc/from_now.h"
#include "common/rpc/link.h"
#include "common/rpc/tcp_socket.h"
#include "common/rpc/unix_socket.h"

namespace sleight::rpc {
namespace {

constexpr std::uint64_t k_traversal_bytes_max = 64U << 20U;  // per answer
// Maximum silence of a server. Servers answer a watch after 20 s even without news, and a read of a
// file sooner.
constexpr double k_silence_s_max = 90;

/// Returns the event loop shared by all clients of a thread, because KJ allows only one per thread.
std::shared_ptr<kj::AsyncIoContext> events_of_thread() {
  thread_local std::weak_ptr<kj::AsyncIoContext> held;
  auto events = held.lock();
  if (!events) held = events = std::make_shared<kj::AsyncIoContext>(kj::setupAsyncIo());
  return events;
}

using RemoteCalls = generated::Service::Client;

constexpr auto no_parameters = [](auto& /*request*/) {};

capnp::ReaderOptions reader_options() {
  capnp::ReaderOptions options;
  options.traversalLimitInWords = k_traversal_bytes_max / sizeof(capnp::word);
  return options;
}

}  // namespace

struct Client::Impl final : Link {
  struct Connection {
    explicit Connection(kj::Own<kj::AsyncIoStream> connected)
        : stream(kj::mv(connected)),
          network(*stream, capnp::rpc::twoparty::Side::CLIENT, reader_options()),
          system(capnp::makeRpcClient(network)),
          service(nullptr) {}
    kj::Own<kj::AsyncIoStream> stream;
    capnp::TwoPartyVatNetwork network;
    capnp::RpcSystem<capnp::rpc::twoparty::VatId> system;
    generated::Service::Client service;
    std::vector<generated::File::Client> files{};
  };

  Impl(ServicePlace called, ClientOptions chosen)
      : place(std::move(called)),
        name(name_of(place)),
        options(chosen),
        io(events_of_thread()),
        interrupts(make_event_descriptor()),
        observer(io->unixEventPort, interrupts.get(), kj::UnixEventPort::FdObserver::OBSERVE_READ) {
  }

  ~Impl() noexcept override {}
  KJ_DISALLOW_COPY(Impl);

  // -------------------------------------------------------------------------------------- waiting

  /// Waits for an answer. Converts failures into the exceptions of client.h and link.h. `seconds`
  /// <= 0: no limit.
  template <class T>
  T wait(kj::Promise<T> promise, double seconds) {
    try {
      if (seconds > 0)
        promise = io->provider->getTimer().timeoutAt(from_now(seconds), kj::mv(promise));
      return promise.wait(io->waitScope);
    } catch (const kj::Exception& error) {
      sort(error);
    }
  }

  /// Like wait(), but interrupt() ends the wait. A server that is silent for `silence_s_max` counts
  /// as lost.
  template <class T>
  T wait_interruptibly(kj::Promise<T> promise, double silence_s_max) {
    if (take_interrupt()) throw Interrupted();
    if (silence_s_max > 0) {
      promise = promise.exclusiveJoin(
          io->provider->getTimer().atTime(from_now(silence_s_max)).then([]() -> T {
            kj::throwFatalException(KJ_EXCEPTION(DISCONNECTED, "silent"));
          }));
    }
    bool is_interrupted = false;
    auto interrupted = observer.whenBecomesReadable().then([&]() -> T {
      is_interrupted = true;
      kj::throwFatalException(KJ_EXCEPTION(FAILED, "interrupted"));
    });
    try {
      return promise.exclusiveJoin(kj::mv(interrupted)).wait(io->waitScope);
    } catch (const kj::Exception& error) {
      if (is_interrupted && take_interrupt()) throw Interrupted();
      sort(error);
    }
  }

  [[noreturn]] void sort(const kj::Exception& error) {
    switch (error.getType()) {
      case kj::Exception::Type::DISCONNECTED:
        connection = nullptr;
        throw Lost("lost the connection to the server");
      case kj::Exception::Type::UNIMPLEMENTED:
        throw RefusedError({.kind = RefusalKind::not_found,
                            .sentence =
                                "The server doesn't support this call: its version differs from "
                                "this program's.",
                            .what_to_do = "To restart the server, run `sleight server stop`, then "
                                          "`sleight server start`; running jobs keep running."});
      case kj::Exception::Type::OVERLOADED:
        connection = nullptr;
        throw base::Error(fmt::format("the server at {} does not answer; see its log", name));
      default:
        connection = nullptr;
        throw RefusedError({.kind = RefusalKind::bug,
                            .sentence = "The server's answer is malformed.",
                            .what_to_do = "See the server's log."});
    }
  }

  bool take_interrupt() { return drain_events(interrupts.get()) > 0; }

  // ----------------------------------------------------------------------------------- connecting

  Connection& connected() {
    KJ_IF_MAYBE (there, connection) {
      return **there;
    }
    const auto* remote = std::get_if<RemoteService>(&place);
    auto made = kj::heap<Connection>(remote == nullptr ? connect_here(std::get<std::string>(place))
                                                       : connect_over_tls(*remote));
    capnp::MallocMessageBuilder builder;
    auto server = builder.initRoot<capnp::rpc::twoparty::VatId>();
    server.setSide(capnp::rpc::twoparty::Side::SERVER);
    auto entrance = made->system.bootstrap(server).castAs<generated::Entrance>();
    if (remote == nullptr) {
      made->service = entered<generated::Entrance::OpenResults>(entrance.openRequest().send());
    } else {
      auto login = entrance.loginRequest();
      login.setToken(as_text(remote->token));
      made->service = entered<generated::Entrance::LoginResults>(login.send());
    }
    connection = kj::mv(made);
    return *KJ_ASSERT_NONNULL(connection);
  }

  template <class Results, class Sent>
  generated::Service::Client entered(Sent sent) {
    auto opened = wait(kj::Promise<capnp::Response<Results>>(kj::mv(sent)), options.call_s_max);
    if (opened.hasRefusal()) throw RefusedError(get(opened.getRefusal()));
    return opened.getService();
  }

  kj::Own<kj::AsyncIoStream> connect_here(const std::string& path) {
    const auto descriptor = connect_to(path);
    if (!descriptor) {
      if (descriptor.error() == Unconnected::busy)
        throw Lost("the server is too busy to accept a connection");
      throw NoServer(
          fmt::format("no server listens at {}; start it with `sleight server start`", path));
    }
    return io->lowLevelProvider->wrapSocketFd(kj::AutoCloseFd(descriptor.value()),
                                              kj::LowLevelAsyncIoProvider::ALREADY_CLOEXEC |
                                                  kj::LowLevelAsyncIoProvider::ALREADY_NONBLOCK);
  }

  kj::Own<kj::AsyncIoStream> connect_over_tls(const RemoteService& remote) {
    auto raw = reach(remote.address);
    KJ_IF_MAYBE (descriptor, raw->getFd()) {
      tune(*descriptor);
    }
    const std::string& host = remote.own_name.empty() ? remote.address.host : remote.own_name;
    try {
      kj::TlsContext::Options tls;
      tls.minVersion = kj::TlsVersion::TLS_1_2;
      tls.useSystemTrustStore = remote.certificate.empty();
      kj::Vector<kj::TlsCertificate> trusted;
      for (const std::string& one : access::certificates_in(remote.certificate))
        trusted.add(kj::StringPtr(one.c_str()));
      tls.trustedCertificates = trusted;
      kj::TlsContext context(tls);
      auto shaken = context.wrapClient(kj::mv(raw), kj::StringPtr(host.c_str()));
      return io->provider->getTimer()
          .timeoutAt(from_now(options.call_s_max), kj::mv(shaken))
          .wait(io->waitScope);
    } catch (const kj::Exception& error) {
      if (error.getType() == kj::Exception::Type::DISCONNECTED)
        throw Lost("the server closed the connection");
      if (error.getType() == kj::Exception::Type::OVERLOADED)
        throw base::Error(fmt::format("the program that answers at {} does not use TLS", name));
      throw NotTrusted(base::ExitCode::not_allowed, why_not_trusted(remote, host));
    }
  }

  std::string why_not_trusted(const RemoteService& remote, const std::string& host) const {
    const double patience_s = options.call_s_max;
    if (!remote.own_name.empty() &&
        access::fingerprint_of(access::certificate_shown_at(remote.address, patience_s)) !=
            access::fingerprint_of(remote.certificate)) {
      return fmt::format(
          "the certificate of the server at {0} has changed since the login: the server has a new "
          "certificate, or someone is intercepting the connection. Confirm the new certificate "
          "with the server's operator, then run `sleight login {0}` again",
          name);
    }
    const std::string fault =
        access::fault_of_certificate_at(remote.address, host, remote.certificate, patience_s);
    return fmt::format(
        "the certificate of the server at {} is not trusted: {}", name,
        fault.empty() ? "the certificate does not contain this host's DNS name" : fault);
  }

  kj::Own<kj::AsyncIoStream> reach(const access::ServerAddress& address) {
    auto& network = io->provider->getNetwork();
    auto& timer = io->provider->getTimer();
    try {
      auto reached = network.parseAddress(address.host.c_str(), address.port)
                         .then([](kj::Own<kj::NetworkAddress> found) {
                           auto connected = found->connect();
                           return connected.attach(kj::mv(found));
                         });
      return timer.timeoutAt(from_now(options.call_s_max), kj::mv(reached)).wait(io->waitScope);
    } catch (const kj::Exception& error) {
      if (error.getType() == kj::Exception::Type::FAILED)
        throw NoServer(fmt::format("can't find the host named in {}", name));
      throw NoServer(fmt::format("no server answers at {}", name));
    }
  }

  static std::string name_of(const ServicePlace& place) {
    const auto* remote = std::get_if<RemoteService>(&place);
    return remote == nullptr ? std::get<std::string>(place) : access::text_of(remote->address);
  }

  /// If a call loses its connection, repeats the call for a limited time.
  template <class Call>
  auto repeat(const Call& call) {
    const double began_s = now_s();
    for (double wait_s = options.first_wait_s;; wait_s = std::min(2 * wait_s, options.wait_s_max)) {
      try {
        return call();
      } catch (const Lost& lost) {
        if (now_s() - began_s > options.call_s_max)
          throw NoServer(fmt::format("{} at {}; several attempts failed", lost.what(), name));
      }
      was_repeated = true;
      wait(kj::Promise<void>(io->provider->getTimer().atTime(from_now(wait_s))), 0);
    }
  }

  /// Makes a call. `fill` sets the request's parameters. `read` extracts the value from the
  /// results.
  template <class Request, class Fill, class Read>
  auto call(Request (RemoteCalls::*begin)(kj::Maybe<capnp::MessageSize>), const Fill& fill,
            const Read& read) {
    was_repeated = false;
    return repeat([&] {
      Request request = (connected().service.*begin)(nullptr);
      fill(request);
      auto sent = request.send();
      using Results = decltype(sent.wait(io->waitScope));
      const Results results = wait(kj::Promise<Results>(kj::mv(sent)), options.call_s_max);
      return read_of(results, read);
    });
  }

  template <class Results, class Read>
  auto read_of(const Results& results, const Read& read) {
    try {
      if (results.hasRefusal()) throw RefusedError(get(results.getRefusal()));
      return read(results);
    } catch (const kj::Exception& error) {
      sort(error);
    }
  }

  // ------------------------------------------------------------------------------ watch and fetch

  std::vector<ArrivedBatch> watch(const std::vector<WatchPoint>& points) override {
    auto request = connected().service.watchRequest();
    put_all(points, request.initPoints(static_cast<unsigned>(points.size())));
    using Results = capnp::Response<generated::Service::WatchResults>;
    const Results results =
        wait_interruptibly(kj::Promise<Results>(request.send()), k_silence_s_max);
    return read_of(results, [](const Results& arrived) { return get_all(arrived.getBatches()); });
  }

  ArrivedFiles fetch(const FetchAsk& ask) override {
    auto& files = connected().files;
    files.clear();
    auto request = connected().service.fetchRequest();
    put(ask, request.initAsk());
    using Results = capnp::Response<generated::Service::FetchResults>;
    Results results = wait_interruptibly(kj::Promise<Results>(request.send()), 0);
    return read_of(results, [&](const Results& arrived) {
      ArrivedFiles to = {.files = {}, .has_more = arrived.getHasMore()};
      for (const auto file : arrived.getFiles()) {
        to.files.push_back(get(file));
        files.push_back(file.getFile());
      }
      return to;
    });
  }

  base::Bytes read(std::size_t file, std::uint64_t offset, std::uint32_t bytes) override {
    auto& files = connected().files;
    // If the file is missing, it was opened over a connection that was lost.
    if (file >= files.size()) throw Lost("lost the connection to the server");
    auto request = files[file].readRequest();
    request.setOffset(offset);
    request.setBytes(bytes);
    using Results = capnp::Response<generated::File::ReadResults>;
    const Results results = wait_interruptibly(kj::Promise<Results>(request.send()), 0);
    return read_of(results, [&](const Results& arrived) {
      const auto piece = arrived.getPiece();
      if (piece.size() != bytes) {
        throw RefusedError({.kind = RefusalKind::bug,
                            .sentence = "The server sent the wrong part of a file.",
                            .what_to_do = ""});
      }
      const auto* first = reinterpret_cast<const std::byte*>(piece.begin());
      return base::Bytes(first, first + piece.size());
    });
  }

  void pause(double seconds) override {
    wait_interruptibly(kj::Promise<void>(io->provider->getTimer().atTime(from_now(seconds))), 0);
  }

  double now_s() const override { return clock.now_s(); }

  ServicePlace place;
  std::string name;  ///< the server's address, for messages
  ClientOptions options;
  std::shared_ptr<kj::AsyncIoContext> io;
  kj::AutoCloseFd interrupts;  ///< an eventfd
  kj::UnixEventPort::FdObserver observer;
  kj::Maybe<kj::Own<Connection>> connection;
  bool was_repeated = false;  ///< the last call; the server may have executed it the first time
  base::SteadyClock clock;
};

Client::Client(ServicePlace place, ClientOptions options)
    : impl_(std::make_unique<Impl>(std::move(place), options)) {}

Client::~Client() = default;

void Client::enter() {
  impl_->repeat([&] {
    impl_->connected();
    return Nothing();
  });
}

Submitted Client::submit(const Submission& submission) {
  return impl_->call(
      &RemoteCalls::submitRequest,
      [&](auto& request) { put(submission, request.initSubmission()); },
      [](const auto& results) { return get(results.getSubmitted()); });
}

JobPage Client::list(const ListAsk& ask) {
  return impl_->call(
      &RemoteCalls::listRequest, [&](auto& request) { put(ask, request.initAsk()); },
      [](const auto& results) { return get(results.getPage()); });
}

JobView Client::status(JobId job) {
  return impl_->call(
      &RemoteCalls::statusRequest, [&](auto& request) { request.setJob(job.value); },
      [](const auto& results) { return get(results.getJob()); });
}

LogPiece Client::logs(const LogAsk& ask) {
  return impl_->call(
      &RemoteCalls::logsRequest, [&](auto& request) { put(ask, request.initAsk()); },
      [](const auto& results) { return get(results.getPiece()); });
}

std::vector<Touched> Client::change(const ChangeAsk& ask) {
  try {
    return impl_->call(
        &RemoteCalls::changeRequest, [&](auto& request) { put(ask, request.initAsk()); },
        [](const auto& results) { return get_all(results.getTouched()); });
  } catch (const RefusedError& error) {
    // The first try may have deleted the job, and its answer was lost.
    const RefusalKind kind = error.refusal().kind;
    if (ask.kind == ChangeKind::erase && impl_->was_repeated &&
        (kind == RefusalKind::not_found || kind == RefusalKind::gone))
      return {};
    throw;
  }
}

ServerView Client::info() {
  return impl_->call(&RemoteCalls::infoRequest, no_parameters,
                     [](const auto& results) { return get(results.getServer()); });
}

void Client::drain() {
  impl_->call(&RemoteCalls::drainRequest, no_parameters, [](const auto&) { return Nothing(); });
}

void Client::stop() {
  impl_->call(&RemoteCalls::stopRequest, no_parameters, [](const auto&) { return Nothing(); });
}

TokenView Client::create_token(const TokenAsk& ask) {
  return impl_->call(
      &RemoteCalls::createTokenRequest, [&](auto& request) { put(ask, request.initAsk()); },
      [](const auto& results) { return get(results.getToken()); });
}

std::vector<TokenView> Client::tokens() {
  return impl_->call(&RemoteCalls::listTokensRequest, no_parameters,
                     [](const auto& results) { return get_all(results.getTokens()); });
}

TokenView Client::revoke_token(const std::string& id) {
  return impl_->call(
      &RemoteCalls::revokeTokenRequest, [&](auto& request) { request.setId(as_text(id)); },
      [](const auto& results) { return get(results.getToken()); });
}

Waited Client::watch(const std::vector<WatchPoint>& points, WatchSink& sink) {
  CHECK_LE(points.size(), k_watch_jobs_max);
  return watch_over(*impl_, impl_->options, points, sink);
}

Waited Client::watch(JobId job, std::uint64_t from_number, WatchSink& sink) {
  CHECK_GE(from_number, std::uint64_t{1});
  return watch({{.job = job, .event = from_number - 1, .change = 0, .mark = 0}}, sink);
}

FetchedFiles Client::fetch_file(FetchAsk ask, const std::string& path,
                                const FetchProgress& progress, const FetchCheck& check,
                                AtItsPlace other) {
  return fetch_file_over(*impl_, impl_->options, std::move(ask), path, progress, check, other);
}

FetchedFiles Client::fetch_folder(FetchAsk ask, const std::string& folder,
                                  const FetchProgress& progress, AtItsPlace other) {
  return fetch_folder_over(*impl_, impl_->options, std::move(ask), folder, progress, other);
}

void Client::interrupt() {
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(impl_->interrupts.get(), &one, sizeof one);
}

std::string random_key() {
  std::uint64_t words[2] = {};
  if (::getrandom(words, sizeof words, 0) != static_cast<ssize_t>(sizeof words))
    throw base::Error("the system returned no random numbers");
  return fmt::format("{:016x}{:016x}", words[0], words[1]);
}

}  // namespace sleight::rpc
