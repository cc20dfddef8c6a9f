// Goal: hostile peers are refused, use limited resources, and delay no other client. Method: attack
// a real server over sockets, with short time limits. Other clients must be answered during or
// after each attack.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/property.h"
#include "tests/unit/clients/web/random_request.h"
#include "tests/unit/clients/web/raw_client.h"
#include "tests/unit/clients/web/served.h"

namespace sleight::web {
namespace {

using testing::Browser;
using testing::comes_true;
using testing::Patience;
using testing::RawClient;
using testing::Received;
using testing::Served;

constexpr double k_short_s = 1.5;

TEST(HostilePeers, AreRefusedAndReadNothingOfTheirs) {
  Served served;
  const Browser browser(served.server());
  const std::string host = "Host: " + browser.host() + "\r\n";
  const std::string in = host + "Cookie: " + browser.cookie() + "\r\n";
  const std::string form =
      "POST /api/notes HTTP/1.1\r\n" + in + "Origin: http://" + browser.host() + "\r\n";
  const struct {
    std::string bytes;
    int status;
  } attacks[] = {
      {"GET / HTTP/1.1\r\n\r\n", 400},
      {"GET / HTTP/1.0\r\n\r\n", 400},
      {"GET / HTTP/1.1\r\n" + in + "Host: evil.example\r\n\r\n", 400},
      {"GET / HTTP/1.1\r\n" + in + host + "\r\n", 400},
      {"GET / HTTP/1.1\r\nHost: evil.example:7000\r\nCookie: " + browser.cookie() + "\r\n\r\n",
       421},
      {"GET / HTTP/1.1\r\n" + host + "\r\n", 403},
      {"GET / HTTP/1.1\r\n" + host + "Cookie: sleight-" + std::to_string(served.port()) +
           "=0123evil\r\n\r\n",
       403},
      {"GET /../../etc/evil HTTP/1.1\r\n" + in + "\r\n", 400},
      {"GET /%2e%2e/evil HTTP/1.1\r\n" + in + "\r\n", 400},
      {"GET /evil%00.js HTTP/1.1\r\n" + in + "\r\n", 400},
      {"GET http://evil.example/ HTTP/1.1\r\n" + in + "\r\n", 400},
      {"GET /<script>evil</script> HTTP/1.1\r\n" + host + "\r\n", 403},
      {"GET / HTTP/1.1\r\n" + in + "Origin: http://evil.example\r\n\r\n", 403},
      {"GET / HTTP/1.1\r\n" + in + "Sec-Fetch-Site: cross-site\r\n\r\n", 403},
      {"DELETE /evil HTTP/1.1\r\n" + in + "\r\n", 405},
      {"POST /api/notes HTTP/1.1\r\n" + in +
           "Content-Type: application/json\r\nContent-Length: 4\r\n\r\nevil",
       403},
      {"POST /api/notes HTTP/1.1\r\n" + in +
           "Origin: http://evil.example\r\nContent-Type: text/plain\r\nContent-Length: "
           "4\r\n\r\nevil",
       403},
      {form + "Content-Type: text/plain\r\nContent-Length: 4\r\n\r\nevil", 415},
      {form + "Content-Type: application/x-www-form-urlencoded\r\nContent-Length: 4\r\n\r\nevil",
       415},
      {form +
           "Content-Type: application/json\r\nContent-Length: 4\r\nTransfer-Encoding: "
           "chunked\r\n\r\n" +
           "0\r\n\r\nGET /evil HTTP/1.1\r\n" + in + "\r\n",
       400},
      {form + "Content-Type: application/json\r\nContent-Length: 5000000\r\n\r\nevil", 413},
      {form + "Content-Type: application/json\r\nExpect: evil\r\nContent-Length: 4\r\n\r\nevil",
       417},
      {"GET /" + std::string(20'000, 'e') + " HTTP/1.1\r\n" + in + "\r\n", 431},
      {"GET / HTTP/1.1\r\n" + in + "Evil: " + std::string(200'000, 'e') + "\r\n\r\n", 431},
      {"evil\r\n\r\n", 400},
      {"\x16\x03\x01\x02\x00evil", 400},
  };
  for (const auto& [bytes, status] : attacks) {
    RawClient client(served.port());
    // The server may close the connection while the client is still sending.
    client.send(bytes);
    const Received received = client.receive();
    EXPECT_EQ(received.status, status) << bytes.substr(0, 300);
    EXPECT_EQ((received.head + received.content).find("evil"), std::string::npos)
        << received.content;
    EXPECT_EQ(received.field("Connection"), "close");
    EXPECT_NE(received.field("Content-Security-Policy"), "");
    EXPECT_TRUE(client.is_closed());
  }
  EXPECT_EQ(served.asks(), 0);
  EXPECT_EQ(RawClient(served.port()).ask(browser.get("/a")).status, 200);
}

TEST(HostilePeers, WhoAreStillSendingReadWhyTheyAreRefused) {
  Served served;
  const Browser browser(served.server());
  for (int i = 0; i < 5; ++i) {
    RawClient client(served.port());
    client.send("POST /a HTTP/1.1\r\nHost: " + browser.host() +
                "\r\nContent-Length: 4000000\r\n\r\n");
    client.send(std::string(4'000'000, 'x'));
    EXPECT_EQ(client.receive().status, 403);
  }
}

TEST(HostilePeers, SlowHeadsAndBodiesAreEnded) {
  ServerOptions options;
  options.limits.head_s_max = k_short_s;
  options.limits.body_s_max = k_short_s;
  options.limits.linger_s_max = 0.1;
  Served served(options, Patience::of_limits);
  const Browser browser(served.server());
  RawClient idle(served.port());
  RawClient slow_head(served.port());
  slow_head.send("GET / HTTP/1.1\r\nHost: ");
  RawClient slow_body(served.port());
  slow_body.send(browser.post_head("/a", 100) + "{");
  RawClient waiting(served.port());
  EXPECT_EQ(waiting.ask(browser.post_head("/a", 100, "Expect: 100-continue\r\n")).status, 100);
  // The client sends a byte now and then, which doesn't extend the deadline.
  RawClient dripping(served.port());
  std::thread drops([&] {
    while (dripping.send("G"))
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
  });
  EXPECT_TRUE(idle.is_closed());
  EXPECT_EQ(slow_head.receive().status, 408);
  EXPECT_EQ(slow_body.receive().status, 408);
  EXPECT_EQ(waiting.receive().status, 408);
  EXPECT_EQ(dripping.receive().status, 408);
  drops.join();
  EXPECT_TRUE(comes_true([&] { return served.server().counts().connections == 0; }));
  EXPECT_EQ(served.server().counts().bodies_bytes, 0U);
  RawClient known(served.port());
  EXPECT_EQ(known.ask(browser.get("/a")).status, 200);
  EXPECT_TRUE(known.is_closed());
}

TEST(HostilePeers, WhoReadNothingAreEnded) {
  ServerOptions options;
  options.limits.write_s_max = k_short_s;
  Served served(options, Patience::of_limits);
  const Browser browser(served.server());
  RawClient deaf(served.port(), 4096);
  deaf.send(browser.get("/large"));
  RawClient reading(served.port());
  EXPECT_EQ(reading.ask(browser.get("/large")).content.size(), 20U << 20U);
  EXPECT_TRUE(comes_true([&] { return served.server().counts().closed == 1; }));
  EXPECT_TRUE(comes_true([&] { return served.server().counts().answers_bytes == 0; }));
  EXPECT_EQ(reading.ask(browser.get("/a")).status, 200);
}

TEST(HostilePeers, AnswersThatNobodyReadsAreBounded) {
  ServerOptions options;
  options.limits.answers_bytes_max = 50U << 20U;  // two answers and a half
  Served served(options);
  const Browser browser(served.server());
  std::vector<std::unique_ptr<RawClient>> deaf;
  for (std::uint64_t i = 1; i <= 5; ++i) {
    deaf.push_back(std::make_unique<RawClient>(served.port(), 4096));
    deaf.back()->send(browser.get("/large"));
    EXPECT_TRUE(comes_true([&] {
      const ServerCounts counts = served.server().counts();
      return counts.closed == (i > 2 ? i - 2 : 0) && counts.asks == i + 1 &&
             counts.answers_bytes == std::min<std::size_t>(i, 2) * (20U << 20U);
    })) << i;
    EXPECT_LE(served.server().counts().answers_bytes, 60U << 20U);
  }
  EXPECT_EQ(RawClient(served.port()).ask(browser.get("/a")).status, 200);
}

TEST(HostilePeers, BodiesOfAllAreBounded) {
  ServerOptions options;
  options.limits.bodies_bytes_max = 10U << 20U;
  Served served(options);
  const Browser browser(served.server());
  std::vector<std::unique_ptr<RawClient>> senders;
  int refused = 0;
  for (int i = 0; i < 20; ++i) {
    senders.push_back(std::make_unique<RawClient>(served.port()));
    senders.back()->send(browser.post_head("/a", 4U << 20U, "Expect: 100-continue\r\n"));
    const int status = senders.back()->receive().status;
    EXPECT_TRUE(status == 100 || status == 503) << status;
    if (status == 503) ++refused;
    EXPECT_LE(served.server().counts().bodies_bytes, 10U << 20U);
  }
  EXPECT_EQ(refused, 18);
  EXPECT_EQ(RawClient(served.port()).ask(browser.get("/a")).status, 200);
  senders.clear();
  EXPECT_TRUE(comes_true([&] { return served.server().counts().bodies_bytes == 0; }));
  EXPECT_EQ(RawClient(served.port()).ask(browser.post("/a", "{}")).status, 200);
}

TEST(HostilePeers, StreamsThatNobodyReadsAreEnded) {
  ServerOptions options;
  options.limits.stream_bytes_max = 1U << 20U;
  Served served(options);
  const Browser browser(served.server());
  RawClient deaf(served.port(), 4096);
  deaf.send(browser.stream());
  RawClient reading(served.port());
  reading.send(browser.stream());
  EXPECT_TRUE(comes_true([&] { return served.server().counts().streams == 2; }));
  const std::string data(300'000, 'd');
  for (int i = 0; i < 30; ++i) {
    served.server().publish("gallery", data + std::to_string(i));
    const std::string end = data + std::to_string(i) + "\n\n";
    EXPECT_TRUE(reading.receive_until(end).ends_with(end)) << i;
  }
  EXPECT_EQ(served.server().counts().streams, 1U);
  EXPECT_EQ(served.server().counts().closed, 1U);
}

TEST(HostilePeers, AboveTheLimitAreToldSo) {
  ServerOptions options;
  options.limits.connections_max = 8;
  Served served(options);
  const Browser browser(served.server());
  EXPECT_TRUE(comes_true([&] { return served.server().counts().connections == 0; }));
  // If a connection has sent the cookie, it stays open when many other connections arrive.
  std::vector<std::unique_ptr<RawClient>> known;
  for (int i = 0; i < 8; ++i) {
    known.push_back(std::make_unique<RawClient>(served.port()));
    EXPECT_EQ(known.back()->ask(browser.get("/a")).status, 200);
  }
  std::vector<std::unique_ptr<RawClient>> others;
  for (int i = 0; i < 50; ++i) {
    others.push_back(std::make_unique<RawClient>(served.port()));
    // The answer is 503. There may be no answer if the server is already sending many refusals.
    const int status = others.back()->receive().status;
    EXPECT_TRUE(status == 503 || status == 0) << status;
    EXPECT_TRUE(i >= 10 || status == 503) << i;
    EXPECT_LE(served.server().counts().connections, 8U + 16U);
  }
  for (const auto& client : known)
    EXPECT_EQ(client->ask(browser.get("/a")).status, 200);
}

TEST(HostilePeers, WithoutTheCookieMakeRoom) {
  ServerOptions options;
  options.limits.connections_max = 8;
  options.limits.idle_grace_s = 0;
  Served served(options);
  const Browser browser(served.server());
  RawClient known(served.port());
  EXPECT_EQ(known.ask(browser.get("/a")).status, 200);
  std::vector<std::unique_ptr<RawClient>> idle;
  for (int i = 0; i < 100; ++i) {
    idle.push_back(std::make_unique<RawClient>(served.port()));
    idle.back()->send("GET / HT");
    if (i % 10 == 0) {
      EXPECT_EQ(RawClient(served.port()).ask(browser.get("/a")).status, 200);
      EXPECT_LE(served.server().counts().connections, 8U + 16U);
    }
  }
  EXPECT_EQ(known.ask(browser.get("/a")).status, 200);
}

std::size_t resident_bytes() {
  std::size_t pages = 0;
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen("/proc/self/statm", "r"),
                                                             &std::fclose);
  if (!file || std::fscanf(file.get(), "%*u %zu", &pages) != 1) return 0;
  return pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

// Goal: random requests (random_request.h) neither crash the server nor use unlimited memory.
TEST(HostilePeers, SendAnything) {
  constexpr std::uint64_t k_seed = 28;
  Served served({}, Patience::of_limits);
  const Browser browser(served.server());
  const std::string own_port = std::to_string(served.port());
  const std::size_t before = resident_bytes();
  for (const std::uint64_t n : property::cases(property::of_tier(200, 1000))) {
    random::Stream stream({.seed = k_seed, .purpose = random::Purpose::prior}, n);
    std::string bytes = testing::random_connection(stream);
    // Insert this server's port and cookie, so that some requests pass.
    for (std::size_t at = 0; (at = bytes.find("7000", at)) != std::string::npos; ++at)
      bytes.replace(at, 4, own_port);
    const std::string secret = browser.cookie().substr(browser.cookie().find('=') + 1);
    for (std::size_t at = 0; (at = bytes.find(testing::k_secret, at)) != std::string::npos; ++at)
      bytes.replace(at, testing::k_secret.size(), secret);
    RawClient client(served.port());
    client.send(bytes);
    if (testing::one_in(stream, 4)) continue;  // close the connection silently
    client.end_sending();
    // Every answer starts with an HTTP status line. A stream of events ends when its client stops
    // sending.
    const std::string received = client.receive_until("never sent");
    EXPECT_TRUE(received.empty() || received.starts_with("HTTP/1.1 ")) << received;
  }
  EXPECT_EQ(RawClient(served.port()).ask(browser.get("/a")).status, 200);
  EXPECT_TRUE(comes_true([&] { return served.server().counts().bodies_bytes == 0; }));
  EXPECT_TRUE(served.complaints().empty());
#ifndef SLEIGHT_SANITIZED
  EXPECT_LT(resident_bytes(), before + (64U << 20U));
#else
  EXPECT_GT(before, 0U);
#endif
}

}  // namespace
}  // namespace sleight::web
