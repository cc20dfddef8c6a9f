// Goal: over TLS, only clients with a valid token are served, and revoking a token ends its
// sessions. A client sends no token to an untrusted server. If a client has no token, it doesn't
// disturb others. Method: connect over loopback to a server that has a generated certificate. Count
// the logins.
#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <mutex>
#include <set>
#include <thread>

#include "common/access/certificates.h"
#include "common/access/token_text.h"
#include "common/base/clock.h"
#include "common/random/stream.h"
#include "common/rpc/client.h"
#include "tests/unit/common/rpc/fake_service.h"

namespace sleight::rpc {
namespace {

using testing::FakeService;
using testing::ServerThread;

class SetAuthority final : public Authority {
 public:
  base::Result<Caller, Refusal> login(const std::string& token,
                                      const std::string& address) override {
    const std::lock_guard lock(mutex_);
    ++logins;
    if (!tokens_.contains(token))
      return Refusal{.kind = RefusalKind::not_allowed, .sentence = "This token is not valid here."};
    return Caller{.user = 4001, .address = address, .token_id = token, .scopes = Scopes::all()};
  }
  bool lets_go_on(const Caller& caller) override {
    const std::lock_guard lock(mutex_);
    return tokens_.contains(caller.token_id);
  }
  void add(const std::string& token) {
    const std::lock_guard lock(mutex_);
    tokens_.insert(token);
  }
  void remove(const std::string& token) {
    const std::lock_guard lock(mutex_);
    tokens_.erase(token);
  }
  std::atomic<int> logins = 0;

 private:
  std::mutex mutex_;
  std::set<std::string> tokens_;
};

class TlsTest : public testing::SocketFolder {
 protected:
  explicit TlsTest(ServerLimits limits = {})
      : token_(access::text_of(access::draw_token())), server_(socket(), service_, limits) {
    service_.jobs[1].view = {.id = {1}, .name = "one", .state = JobState::running};
    authority_.add(token_);
    server_.on_loop([&](Server& server) {
      address_ = server.listen({.host = "127.0.0.1", .port = 0}, keypair_, authority_);
    });
  }
  RemoteService remote() const {
    return {.address = address_,
            .token = token_,
            .certificate = keypair_.certificate,
            .own_name = access::k_self_name};
  }
  int connect_raw() const {
    const int descriptor = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in to = {};
    to.sin_family = AF_INET;
    to.sin_port = htons(address_.port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(descriptor, reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
    return descriptor;
  }
  void expect_served() {
    Client client(remote(), {.call_s_max = 10});
    EXPECT_EQ(client.status({1}).name, "one");
  }

  access::Keypair keypair_ = access::make_self_signed();
  SetAuthority authority_;
  FakeService service_;
  std::string token_;
  access::ServerAddress address_;
  ServerThread server_;  // last, so destroyed first
};

bool is_ended(int descriptor, int patience_ms) {
  char buffer[4096];
  pollfd looked = {.fd = descriptor, .events = POLLIN, .revents = 0};
  while (::poll(&looked, 1, patience_ms) > 0) {
    if (::read(descriptor, buffer, sizeof buffer) <= 0) return true;
  }
  return false;
}

TEST_F(TlsTest, ATokenIsItsUsersCall) {
  Client client(remote());
  EXPECT_EQ(client.status({1}).name, "one");
  server_.on_loop([&](Server&) {
    EXPECT_EQ(service_.last_caller.user, 4001U);
    EXPECT_EQ(service_.last_caller.token_id, token_);
    EXPECT_TRUE(service_.last_caller.address.starts_with("127.0.0.1:"));
  });
  EXPECT_EQ(authority_.logins, 1);
}

TEST_F(TlsTest, LargeAnswersAndFilesComeWhole) {
  server_.on_loop([&](Server&) {
    service_.add_file("ball.h5", testing::content_of(3'000'000, 7));
    service_.jobs[1].view.end_words = std::string(k_text_bytes_max, 'x');
  });
  Client client(remote());
  EXPECT_EQ(client.status({1}).end_words.size(), k_text_bytes_max);
  client.fetch_file({.job = {1}}, path("ball.h5"));
  std::FILE* file = std::fopen(path("ball.h5").c_str(), "rbe");
  ASSERT_NE(file, nullptr);
  std::fseek(file, 0, SEEK_END);
  EXPECT_EQ(std::ftell(file), 3'000'000);
  std::fclose(file);
}

TEST_F(TlsTest, AWrongTokenIsRefusedAndItsConnectionEnded) {
  RemoteService wrong = remote();
  wrong.token = access::text_of(access::draw_token());
  Client client(wrong);
  try {
    client.status({1});
    FAIL() << "it was let in";
  } catch (const RefusedError& error) {
    EXPECT_EQ(error.refusal().kind, RefusalKind::not_allowed);
  }
  EXPECT_TRUE(testing::comes_true([&] { return server_.counts().strangers == 0; }));
  expect_served();
}

TEST_F(TlsTest, TextsThatAreNoTokenAreNotLookedUp) {
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{77}, std::size_t{79}, std::size_t{4000}}) {
    RemoteService wrong = remote();
    wrong.token = std::string(size, 'a');
    EXPECT_THROW(Client(wrong).enter(), RefusedError) << size;
  }
  EXPECT_EQ(authority_.logins, 0);
}

// If a client has no valid token, its messages have a lower size limit.
TEST_F(TlsTest, AStrangersLargeMessageEndsItsConnection) {
  RemoteService wrong = remote();
  wrong.token = std::string(1U << 20U, 'a');
  EXPECT_THROW(Client(wrong, {.call_s_max = 0.5}).enter(), base::Error);
  EXPECT_EQ(authority_.logins, 0);
  expect_served();
}

TEST_F(TlsTest, ARevokedTokenEndsItsSessions) {
  Client client(remote(), {.call_s_max = 1});
  EXPECT_EQ(client.status({1}).name, "one");
  EXPECT_EQ(server_.counts().connections, 1U);
  authority_.remove(token_);
  // After the token is removed, a call fails and the session's connection ends.
  EXPECT_THROW(client.status({1}), RefusedError);
  EXPECT_TRUE(testing::comes_true([&] { return server_.counts().connections == 0; }));
}

TEST_F(TlsTest, AWaitingWatchEndsWithItsToken) {
  std::atomic<bool> has_ended = false;
  std::thread watching([&] {
    struct Sink final : WatchSink {
      bool changed(JobId, const StateChange&) override { return true; }
      bool happened(const WatchedEvent&) override { return true; }
      bool refused(JobId, const Refusal&) override { return true; }
    } sink;
    Client client(remote(), {.call_s_max = 1, .away_s_max = 1});
    EXPECT_ANY_THROW(client.watch({1}, 1, sink));
    has_ended = true;
  });
  EXPECT_TRUE(testing::comes_true([&] { return server_.counts().watchers == 1; }));
  authority_.remove(token_);
  EXPECT_TRUE(testing::comes_true([&] { return server_.counts().watchers == 0; }));
  watching.join();
  EXPECT_TRUE(has_ended);
}

// If a server has another certificate, it receives nothing, not even the token.
TEST_F(TlsTest, AServerWithAnotherCertificateGetsNoToken) {
  RemoteService other = remote();
  other.certificate = access::make_self_signed().certificate;
  try {
    Client(other, {.call_s_max = 5}).enter();
    FAIL() << "it was trusted";
  } catch (const NotTrusted& error) {
    EXPECT_NE(std::string(error.what()).find("has changed since the login"), std::string::npos);
  }
  // If the trusted certificate is for another host name, the error says that the host name doesn't
  // match, not that the certificate has changed.
  other = remote();
  other.own_name = "another.example.org";
  try {
    Client(other, {.call_s_max = 5}).enter();
    FAIL() << "it was trusted";
  } catch (const NotTrusted& error) {
    EXPECT_NE(std::string(error.what()).find("hostname mismatch"), std::string::npos)
        << error.what();
  }
  other = remote();
  other.own_name = "";
  other.certificate = "";  // the system's authorities, which don't vouch for this certificate
  EXPECT_THROW(Client(other, {.call_s_max = 5}).enter(), NotTrusted);
  EXPECT_EQ(authority_.logins, 0);
}

TEST_F(TlsTest, WhyACertificateIsNotTrustedIsSaid) {
  const auto fault = [&](const std::string& name, const std::string& trusted) {
    return access::fault_of_certificate_at(address_, name, trusted, 5);
  };
  EXPECT_EQ(fault(access::k_self_name, keypair_.certificate), "");
  EXPECT_EQ(fault("another.example.org", keypair_.certificate), "hostname mismatch");
  EXPECT_EQ(fault(access::k_self_name, ""), "self-signed certificate");
}

TEST_F(TlsTest, NobodyThereIsTold) {
  RemoteService gone = remote();
  gone.address.port = 1;
  EXPECT_THROW(Client(gone, {.call_s_max = 2}).enter(), NoServer);
  gone.address.host = "no.such.host.invalid";
  EXPECT_THROW(Client(gone, {.call_s_max = 5}).enter(), NoServer);
}

TEST_F(TlsTest, TheCertificateIsShownToAnybody) {
  const std::string shown = access::certificate_shown_at(address_, 5);
  EXPECT_EQ(access::fingerprint_of(shown), access::fingerprint_of(keypair_.certificate));
}

TEST_F(TlsTest, EachWayInHasItsOwnKey) {
  Client here(socket());
  EXPECT_EQ(here.status({1}).name, "one");
  server_.on_loop([&](Server&) { EXPECT_TRUE(service_.last_caller.token_id.empty()); });
}

class TlsCrowdTest : public TlsTest {
 protected:
  TlsCrowdTest()
      : TlsTest(
            {.connections_max = 40, .idle_grace_s = 0.05, .strangers_max = 8, .login_s_max = 1.0}) {
  }
};

TEST_F(TlsCrowdTest, SilentStrangersAreEndedAndOthersServedMeanwhile) {
  std::vector<int> silent;
  for (int i = 0; i < 40; ++i)
    silent.push_back(connect_raw());
  expect_served();
  EXPECT_LE(server_.counts().strangers, 8U);
  for (const int descriptor : silent) {
    EXPECT_TRUE(is_ended(descriptor, 5000));
    ::close(descriptor);
  }
  expect_served();
}

TEST_F(TlsCrowdTest, SlowHandshakesAreEnded) {
  const int slow = connect_raw();
  const base::SteadyClock clock;
  const double began_s = clock.now_s();
  bool ended = false;
  // Send the beginning of a TLS record one byte at a time.
  const unsigned char head[] = {0x16, 0x03, 0x01, 0x02, 0x00, 0x01, 0x00, 0x01, 0xfc, 0x03, 0x03};
  for (std::size_t i = 0; !ended && clock.now_s() - began_s < 10; ++i) {
    const unsigned char byte = i < sizeof head ? head[i] : 0;
    ended = ::send(slow, &byte, 1, MSG_NOSIGNAL) != 1 || is_ended(slow, 100);
  }
  EXPECT_TRUE(ended);
  ::close(slow);
  expect_served();
}

TEST_F(TlsCrowdTest, BytesThatAreNoTlsAreEnded) {
  random::Stream numbers({.seed = 27, .purpose = random::Purpose::prior}, 0);
  for (int round = 0; round < 200; ++round) {
    const int descriptor = connect_raw();
    std::vector<unsigned char> bytes(1 + numbers.bits() % 2000);
    for (auto& byte : bytes)
      byte = static_cast<unsigned char>(numbers.bits());
    if (round % 2 == 0) bytes[0] = 0x16;  // type of a handshake record
    static_cast<void>(::send(descriptor, bytes.data(), bytes.size(), MSG_NOSIGNAL));
    ::close(descriptor);
  }
  expect_served();
  EXPECT_TRUE(testing::comes_true([&] { return server_.counts().strangers == 0; }));
}

TEST_F(TlsTest, TwoHundredClients) {
  std::atomic<int> served = 0;
  std::vector<std::thread> threads;
  threads.reserve(20);
  for (int thread = 0; thread < 20; ++thread) {
    threads.emplace_back([&] {
      std::vector<std::unique_ptr<Client>> clients;
      for (int i = 0; i < 10; ++i)
        clients.push_back(std::make_unique<Client>(remote(), ClientOptions{.call_s_max = 30}));
      for (int round = 0; round < 3; ++round)
        for (const auto& client : clients)
          if (client->status({1}).name == "one") ++served;
    });
  }
  for (std::thread& thread : threads)
    thread.join();
  EXPECT_EQ(served, 600);
}

}  // namespace
}  // namespace sleight::rpc
