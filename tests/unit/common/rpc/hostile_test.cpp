// Peers that send anything, or read nothing: the server's memory stays bounded, and others are
// served.
//
// The server is a process of its own, whose most memory ever is looked at. After each attack, and
// during it, another client is answered.
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

/// A raw connection.
class Raw {
 public:
  explicit Raw(const std::string& path) : descriptor_(connect_to(path).value()) {}
  ~Raw() { ::close(descriptor_); }
  Raw(const Raw&) = delete;
  Raw& operator=(const Raw&) = delete;

  /// What the system takes within some time; false where the server has ended the connection.
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
  /// What has come and was not read.
  int unread() const {
    int bytes = 0;
    ::ioctl(descriptor_, FIONREAD, &bytes);
    return bytes;
  }
  /// Reads until the server ends the connection, or for so long.
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

  std::size_t received = 0;  ///< by is_ended

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
  /// Others are served.
  void expect_served() {
    Client client(socket(), {.call_s_max = 10});
    EXPECT_EQ(client.info().version, "1.2");
    EXPECT_EQ(client.status({1}).name, "one");
  }
  /// Since the test began.
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

/// A call of the service that the bootstrap's `open` promises, as question 1 of a connection.
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

/// Bootstrap and open, without waiting for an answer.
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
  // Goal: no bytes harm the server or other clients. Method: random bytes; messages of ours with
  // some bytes changed.
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
      // Sizes that are believable, so that the content is read.
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
  // Goal: what a message announces is judged before it has any space. Method: sizes beyond the
  // limit, too many parts, parts whose sum is too large.
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
  // Goal: a message can't be deeper or say more than its size. Method: a call whose parameters are
  // 200 levels of lists; a submission of 1,000 jobs which all point at one text of 1 MB.
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
  // A list of 1,000 structs whose second pointer is the same far text, by hand: words.
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
  // Goal: messages that never become whole hold no more than their bound, are ended in time, and
  // hinder nobody. Method: 30 connections that announce 4 MB and send a part, where 16 MB are
  // allowed.
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
  // Goal: however many connections there are, others are served, and they cost little. Method:
  // 1,000 that do nothing, half of them with the beginning of a message; clients meanwhile.
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
  // Goal: answers that are not read hold a bounded memory, and their connection is ended in time.
  // Method: connections that ask for the same status, and for pieces of a file, ever again, and
  // read nothing.
  std::vector<std::unique_ptr<Raw>> raws;
  for (int i = 0; i < 20; ++i) {
    raws.push_back(std::make_unique<Raw>(socket()));
    open(*raws.back());
  }
  // Answers have come, unread, where all connections have more than before, and equally much.
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
  wait_for_more_than(opened);  // now the files are known
  for (const auto& raw : raws) {
    for (std::uint32_t question = 3; question < 60; ++question) {
      capnp::MallocMessageBuilder message;
      auto call = message.initRoot<capnp::rpc::Message>().initCall();
      call.setQuestionId(question);
      call.getSendResultsTo().setCaller();
      // The files are a list, which no promise can be followed into: so by the capability's number,
      // which is the third that the connection was given.
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
    // The attack was one: the beginning of a piece filled what the system keeps.
    EXPECT_GT(raw->received, 100'000U);
    EXPECT_LT(raw->received, k_megabyte);
  }
  expect_served();
  expect_bounded(40 * k_megabyte);
}

TEST_F(HostileTest, QuestionsWithoutEndAndAnswersThatAreKept) {
  // Goal: a peer can't make the server keep answers: neither by never letting go of them, nor by
  // having them kept for others. Method: more questions than are allowed, with their answers read;
  // a call whose results are to stay.
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
  // Goal: a peer can't make the server keep what it has said of capabilities of its own, as
  // Cap'n Proto would, for ever. Method: each message that says something of one ends its
  // connection; a call without any does not.
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
  // One that brings none is not ended.
  Raw plain(socket());
  open(plain);
  capnp::MallocMessageBuilder call;
  call_of_service(call, 2, 13);
  plain.send(call);
  EXPECT_FALSE(plain.is_ended(200));
  expect_served();
}

TEST_F(HostileTest, MoreCallsAtOnceThanAllowedAreRefused) {
  // Goal: a connection's calls at once are bounded, and a watch that is dropped is forgotten.
  // Method: more watches on one connection than are allowed; some are dropped, and as many come in
  // anew.
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
