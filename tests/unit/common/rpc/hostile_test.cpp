// Goal: whatever a peer sends or doesn't read, the server's memory stays bounded, and other clients
// are served. Method: measure the peak memory of a server in its own process. Another client makes
// calls during and after each attack.
#include <capnp/message.h>
#include <capnp/rpc-twoparty.h>
#include <capnp/rpc.capnp.h>
#include <capnp/serialize.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <kj/async-io.h>
#include <poll.h>
#include <service.capnp.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <functional>
#include <memory>
#include <thread>

#include "common/random/stream.h"
#include "common/rpc/client.h"
#include "common/rpc/unix_socket.h"
#include "tests/support/property.h"
#include "tests/unit/common/rpc/fake_service.h"

namespace sleight::rpc {
namespace {

using testing::ServerProcess;

constexpr std::size_t k_megabyte = 1U << 20U;

class Raw {
 public:
  explicit Raw(const std::string& path) : descriptor_(connect_to(path).value()) {}
  ~Raw() { ::close(descriptor_); }
  Raw(const Raw&) = delete;
  Raw& operator=(const Raw&) = delete;

  /// Sends as many bytes as possible within the time limit. Returns false if the server ended the
  /// connection.
  bool send(const void* bytes, std::size_t size, int patience_ms = 2000) {
    const char* next = static_cast<const char*>(bytes);
    while (size > 0) {
      pollfd looked = {.fd = descriptor_, .events = POLLOUT, .revents = 0};
      if (::poll(&looked, 1, patience_ms) <= 0) return true;
      const auto sent = ::send(descriptor_, next, size, MSG_NOSIGNAL);
      if (sent < 0) return errno == EAGAIN;
      next += sent;
      size -= static_cast<std::size_t>(sent);
    }
    return true;
  }
  bool send(capnp::MessageBuilder& message, int patience_ms = 2000) {
    const auto words = capnp::messageToFlatArray(message);
    return send(words.begin(), words.asBytes().size(), patience_ms);
  }
  int unread() const {
    int bytes = 0;
    ::ioctl(descriptor_, FIONREAD, &bytes);
    return bytes;
  }
  /// Reads until the server ends the connection or the time limit is over.
  bool is_ended(int patience_ms = 5000) {
    char buffer[4096];
    pollfd looked = {.fd = descriptor_, .events = POLLIN, .revents = 0};
    while (::poll(&looked, 1, patience_ms) > 0) {
      const auto got = ::read(descriptor_, buffer, sizeof buffer);
      if (got == 0 || (got < 0 && errno != EAGAIN)) return true;
      if (got > 0) received += static_cast<std::size_t>(got);
    }
    return false;
  }

  std::size_t received = 0;  ///< bytes read by is_ended

 private:
  int descriptor_;
};

class HostileTest : public testing::SocketFolder {
 protected:
  HostileTest() : server_(socket(), *shared_, 8 * k_megabyte, limits()), before_(peak()) {}

  static ServerLimits limits() {
    return {.connections_max = 40,
            .held_bytes_max = 16 * k_megabyte,
            .idle_grace_s = 0.05,
            .message_s_max = 0.6};
  }
  std::size_t peak() const { return server_.peak_bytes(); }
  void expect_served() {
    Client client(socket(), {.call_s_max = 10});
    EXPECT_EQ(client.info().version, "1.2");
    EXPECT_EQ(client.status({1}).name, "one");
  }
  void expect_bounded(std::size_t bytes_max) {
    testing::expect_grown_less(server_, before_, bytes_max);
  }

  std::shared_ptr<testing::Shared> shared_ = testing::make_shared_memory();
  ServerProcess server_;
  std::size_t before_;
};

void ask_for_bootstrap(capnp::MessageBuilder& message, std::uint32_t question) {
  message.initRoot<capnp::rpc::Message>().initBootstrap().setQuestionId(question);
}

/// Starts a call to the service. open() has requested the service as question 1 of the connection.
capnp::rpc::Call::Builder call_of_service(capnp::MessageBuilder& message, std::uint32_t question,
                                          std::uint16_t method) {
  auto call = message.initRoot<capnp::rpc::Message>().initCall();
  call.setQuestionId(question);
  auto answer = call.initTarget().initPromisedAnswer();
  answer.setQuestionId(1);
  answer.initTransform(1)[0].setGetPointerField(1);
  call.setInterfaceId(capnp::typeId<generated::Service>());
  call.setMethodId(method);
  call.getSendResultsTo().setCaller();
  call.initParams();
  return call;
}

void open(Raw& raw) {
  capnp::MallocMessageBuilder bootstrap;
  ask_for_bootstrap(bootstrap, 0);
  raw.send(bootstrap);
  capnp::MallocMessageBuilder message;
  auto call = message.initRoot<capnp::rpc::Message>().initCall();
  call.setQuestionId(1);
  call.initTarget().initPromisedAnswer().setQuestionId(0);
  call.setInterfaceId(capnp::typeId<generated::Entrance>());
  call.setMethodId(0);
  call.getSendResultsTo().setCaller();
  call.initParams();
  raw.send(message);
}

TEST_F(HostileTest, AnyBytes) {
  // Goal: no bytes harm the server or other clients. Method: send random bytes and damaged
  // messages.
  for (const std::uint64_t n : property::cases(property::of_tier(40, 120))) {
    random::Stream stream({.seed = 25, .purpose = random::Purpose::prior}, n);
    Raw raw(socket());
    std::string bytes(8 + stream.bits() % 2000, '\0');
    for (char& c : bytes)
      c = static_cast<char>(stream.bits());
    if (n % 2 == 0) {
      open(raw);
      capnp::MallocMessageBuilder message;
      auto call = call_of_service(message, 2, static_cast<std::uint16_t>(stream.bits() % 20));
      call.getParams().getContent().initAs<generated::Service::ListParams>().initAsk().setCount(3);
      const auto words = capnp::messageToFlatArray(message);
      bytes.assign(reinterpret_cast<const char*>(words.begin()), words.asBytes().size());
      for (int i = 0; i < 4; ++i)
        bytes[8 + stream.bits() % (bytes.size() - 8)] = static_cast<char>(stream.bits());
    } else {
      // If the size is plausible, the server reads the content.
      const std::uint32_t head[2] = {0, static_cast<std::uint32_t>((bytes.size() - 8) / 8)};
      std::memcpy(bytes.data(), head, sizeof head);
    }
    raw.send(bytes.data(), bytes.size());
    if (n % 10 == 0) expect_served();
  }
  expect_served();
  expect_bounded(8 * k_megabyte);
}

TEST_F(HostileTest, MessagesThatAreTooLargeEndTheirConnection) {
  // Goal: the server checks the announced size of a message before it allocates memory. Method:
  // announce one size that is too large. Announce too many segments. Announce segments whose total
  // size is too large.
  const std::vector<std::vector<std::uint32_t>> heads = {{0, 0xFFFFFFFF},
                                                         {0, (4U << 20U) / 8 + 1},
                                                         {0xFFFFFFFF, 1},
                                                         {64, 1},
                                                         {1, 0x80000, 0x80000, 0}};
  for (const auto& head : heads) {
    Raw raw(socket());
    raw.send(head.data(), head.size() * sizeof head[0]);
    EXPECT_TRUE(raw.is_ended());
  }
  expect_served();
  expect_bounded(4 * k_megabyte);
}

TEST_F(HostileTest, DeepNestingAndPointersToTheSameWordsAreRefused) {
  // Goal: neither a deeply nested message nor a submission of many jobs harms the server. Method:
  // send a call that has 200 nested levels. Send a submission of 1,000 jobs.
  Raw deep(socket());
  open(deep);
  capnp::MallocMessageBuilder nested;
  auto call = call_of_service(nested, 2, 0);
  auto pointer = call.getParams().getContent();
  for (int i = 0; i < 200; ++i)
    pointer = pointer.initAsAnyStruct(0, 1).getPointerSection()[0];
  deep.send(nested);

  Raw many(socket());
  open(many);
  capnp::MallocMessageBuilder aliased;
  auto submit = call_of_service(aliased, 2, 0);
  auto submission =
      submit.getParams().getContent().initAs<generated::Service::SubmitParams>().initSubmission();
  submission.setKey("k");
  auto jobs = submission.initJobs(1000);
  jobs[0].setRequest(std::string(1000, 'r'));
  auto flat = capnp::messageToFlatArray(aliased);
  many.send(flat.begin(), flat.asBytes().size());

  expect_served();
  expect_bounded(8 * k_megabyte);
}

TEST_F(HostileTest, HalfMessagesAreGivenUp) {
  // Goal: incomplete messages take limited memory, and the server soon ends their connections.
  // Method: open 30 connections that announce 4 MB each and send only a part. The server's limit
  // for all connections is 16 MB.
  std::vector<std::unique_ptr<Raw>> raws;
  const std::uint32_t head[2] = {0, (4U << 20U) / 8};
  const std::string part(100'000, 'x');
  for (int i = 0; i < 30; ++i) {
    raws.push_back(std::make_unique<Raw>(socket()));
    raws.back()->send(head, sizeof head);
    raws.back()->send(part.data(), part.size());
  }
  expect_served();
  for (const auto& raw : raws)
    EXPECT_TRUE(raw->is_ended());
  expect_served();
  expect_bounded(24 * k_megabyte);
}

TEST_F(HostileTest, AThousandConnections) {
  // Goal: while a thousand connections are open, other clients are served, and memory stays low.
  // Method: open 1,000 idle connections. On half of the connections, send part of a message.
  rlimit files = {};
  ::getrlimit(RLIMIT_NOFILE, &files);
  files.rlim_cur = files.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &files);
  std::vector<std::unique_ptr<Raw>> raws;
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(testing::comes_true([&] { return connect_to(socket()).ok(); }));
    raws.push_back(std::make_unique<Raw>(socket()));
    if (i % 2 == 0) raws.back()->send("abc", 3);
    if (i % 250 == 0) expect_served();
  }
  expect_served();
  expect_bounded(16 * k_megabyte);
}

TEST_F(HostileTest, APeerThatNeverReadsIsNotListenedTo) {
  // Goal: if a peer doesn't read its answers, they take limited memory, and the server soon ends
  // the connection. Method: request pieces of a file on 20 connections, and read no answer.
  std::vector<std::unique_ptr<Raw>> raws;
  for (int i = 0; i < 20; ++i) {
    raws.push_back(std::make_unique<Raw>(socket()));
    open(*raws.back());
  }
  // Waits until all connections have the same number of unread bytes, and this number is above
  // `before`.
  const auto wait_for_more_than = [&](int before) {
    EXPECT_TRUE(testing::comes_true([&] {
      const int first = raws.front()->unread();
      return first > before && std::all_of(raws.begin(), raws.end(),
                                           [&](const auto& raw) { return raw->unread() == first; });
    }));
    return raws.front()->unread();
  };
  const int opened = wait_for_more_than(0);
  for (const auto& raw : raws) {
    capnp::MallocMessageBuilder message;
    auto call = call_of_service(message, 2, 12);
    auto ask = call.getParams().getContent().initAs<generated::Service::FetchParams>().initAsk();
    ask.setJob(1);
    ask.setKind(generated::FetchAsk::Kind::ARCHIVE);
    raw->send(message);
  }
  wait_for_more_than(opened);  // the files are open now
  for (const auto& raw : raws) {
    for (std::uint32_t question = 3; question < 60; ++question) {
      capnp::MallocMessageBuilder message;
      auto call = message.initRoot<capnp::rpc::Message>().initCall();
      call.setQuestionId(question);
      call.getSendResultsTo().setCaller();
      // A promise can't refer to an element of a list, so address the file by its capability
      // number. The file is the connection's third capability.
      call.initTarget().setImportedCap(2);
      call.setInterfaceId(capnp::typeId<generated::File>());
      call.setMethodId(0);
      auto read = call.initParams().getContent().initAs<generated::File::ReadParams>();
      read.setOffset(0);
      read.setBytes(1U << 20U);
      if (!raw->send(message, 20)) break;
    }
  }
  expect_served();
  std::this_thread::sleep_for(std::chrono::duration<double>(2 * limits().message_s_max));
  for (const auto& raw : raws) {
    EXPECT_TRUE(raw->is_ended());
    // Check that the attack worked: the first part of a piece filled the system's buffers.
    EXPECT_GT(raw->received, 100'000U);
    EXPECT_LT(raw->received, k_megabyte);
  }
  expect_served();
  expect_bounded(40 * k_megabyte);
}

TEST_F(HostileTest, QuestionsWithoutEndAndAnswersThatAreKept) {
  // Goal: a peer can't make the server store any number of answers. Method: ask more questions than
  // allowed. Make a call that tells the server to keep the results.
  Raw many(socket());
  open(many);
  bool is_ended = false;
  for (std::uint32_t question = 2; question < 200 && !is_ended; ++question) {
    capnp::MallocMessageBuilder message;
    call_of_service(message, question, 13);
    is_ended = !many.send(message, 20);
  }
  EXPECT_TRUE(many.is_ended());

  Raw kept(socket());
  open(kept);
  capnp::MallocMessageBuilder message;
  call_of_service(message, 2, 13).getSendResultsTo().setYourself();
  kept.send(message);
  EXPECT_TRUE(kept.is_ended());
  expect_served();
}

TEST_F(HostileTest, APeerBringsNoCapabilities) {
  // Goal: if a message brings a capability of the peer, the server refuses it, because Cap'n Proto
  // would keep the capability forever. Method: send one message of each kind that brings a
  // capability. The server must end the connection each time.
  using Make = std::function<void(capnp::rpc::Message::Builder)>;
  const std::vector<Make> messages = {
      [](auto message) { message.initResolve().initCap().setSenderPromise(0); },
      [](auto message) { message.initReturn().initResults(); },
      [](auto message) { message.initDisembargo().initTarget().setImportedCap(0); },
      [](auto message) { message.initUnimplemented().initResolve(); },
      [](auto message) { message.initProvide().initTarget().setImportedCap(0); },
      [](auto message) { message.initAccept(); },
      [](auto message) { message.initJoin().initTarget().setImportedCap(0); },
  };
  for (const Make& make : messages) {
    Raw raw(socket());
    open(raw);
    capnp::MallocMessageBuilder message;
    make(message.initRoot<capnp::rpc::Message>());
    raw.send(message);
    EXPECT_TRUE(raw.is_ended());
  }
  Raw brings(socket());
  open(brings);
  capnp::MallocMessageBuilder message;
  call_of_service(message, 2, 13).getParams().initCapTable(1)[0].setSenderPromise(0);
  brings.send(message);
  EXPECT_TRUE(brings.is_ended());
  Raw plain(socket());
  open(plain);
  capnp::MallocMessageBuilder call;
  call_of_service(call, 2, 13);
  plain.send(call);
  EXPECT_FALSE(plain.is_ended(200));
  expect_served();
}

TEST_F(HostileTest, MoreCallsAtOnceThanAllowedAreRefused) {
  // Goal: the number of simultaneous calls on a connection is limited. If a call is dropped, there
  // is room for a new call. Method: open one more watch than allowed on a connection. Then drop all
  // watches and open a new watch.
  auto io = kj::setupAsyncIo();
  auto stream = io.lowLevelProvider->wrapSocketFd(connect_to(socket()).value(),
                                                  kj::LowLevelAsyncIoProvider::TAKE_OWNERSHIP);
  capnp::TwoPartyVatNetwork network(*stream, capnp::rpc::twoparty::Side::CLIENT);
  auto system = capnp::makeRpcClient(network);
  capnp::MallocMessageBuilder builder;
  auto vat = builder.initRoot<capnp::rpc::twoparty::VatId>();
  vat.setSide(capnp::rpc::twoparty::Side::SERVER);
  auto service = system.bootstrap(vat)
                     .castAs<generated::Entrance>()
                     .openRequest()
                     .send()
                     .wait(io.waitScope)
                     .getService();
  using Results = capnp::Response<generated::Service::WatchResults>;
  std::vector<kj::Promise<Results>> watches;
  const auto watch = [&] {
    auto request = service.watchRequest();
    auto point = request.initPoints(1)[0];
    point.setJob(1);
    point.setChange(1);
    point.setMark(1);
    watches.push_back(request.send());
  };
  const std::size_t calls_max = ServerLimits().calls_max;
  for (std::size_t i = 0; i < calls_max; ++i)
    watch();
  watch();
  const auto refused = watches.back().wait(io.waitScope);
  ASSERT_TRUE(refused.hasRefusal());
  EXPECT_EQ(refused.getRefusal().getKind(), generated::Refusal::Kind::LIMIT);
  watches.clear();
  watch();
  auto& last = watches.back();
  EXPECT_FALSE(last.poll(io.waitScope));
  expect_bounded(8 * k_megabyte);
}

}  // namespace
}  // namespace sleight::rpc
