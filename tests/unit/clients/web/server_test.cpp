// Goal: an authorized browser can use requests, files and event streams as the page needs them.
// Method: send the bytes of a browser's requests to a real server over sockets.
#include "clients/web/server.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "clients/web/keys.h"
#include "common/base/error.h"
#include "tests/unit/clients/web/raw_client.h"
#include "tests/unit/clients/web/served.h"

namespace sleight::web {
namespace {

using testing::Browser;
using testing::comes_true;
using testing::RawClient;
using testing::Received;
using testing::Served;

std::shared_ptr<const StaticFiles> small_page(const std::string& name) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(::testing::TempDir()) / (name + std::to_string(::getpid()));
  fs::create_directories(folder);
  std::ofstream(folder / "index.html") << "<!doctype html>";
  std::ofstream(folder / "index-DkX3_9aQ.js") << std::string(5000, ' ');
  auto files = std::make_shared<const StaticFiles>(folder.string());
  fs::remove_all(folder);
  return files;
}

TEST(Servers, LetInByALinkOnce) {
  Served served;
  const std::string link = served.server().link();
  const std::string host = "127.0.0.1:" + std::to_string(served.port());
  ASSERT_TRUE(link.starts_with("http://" + host + "/?token=")) << link;
  const std::string opened =
      "GET " + link.substr(link.find("/?")) + " HTTP/1.1\r\nHost: " + host + "\r\n\r\n";
  const Received in = RawClient(served.port()).ask(opened);
  EXPECT_EQ(in.status, 303);
  EXPECT_EQ(in.field("Location"), "/");
  const std::string cookie = in.field("Set-Cookie");
  EXPECT_TRUE(cookie.starts_with("sleight-" + std::to_string(served.port()) + "=")) << cookie;
  EXPECT_TRUE(cookie.ends_with("; HttpOnly; SameSite=Strict; Path=/")) << cookie;

  // The link works once, so a second user is refused.
  const Received again = RawClient(served.port()).ask(opened);
  EXPECT_EQ(again.status, 403);
  EXPECT_EQ(again.field("Content-Type"), "text/plain; charset=utf-8");
  EXPECT_NE(again.content.find("Open the link"), std::string::npos) << again.content;
  EXPECT_EQ(again.content.find("token"), std::string::npos);
  const Received outside =
      RawClient(served.port()).ask("GET /api/gallery HTTP/1.1\r\nHost: " + host + "\r\n\r\n");
  EXPECT_EQ(outside.status, 403);
  EXPECT_EQ(outside.field("Content-Type"), "application/json");
  EXPECT_EQ(served.asks(), 0);

  // The server replaces its used link by a new link.
  const std::string second = served.server().new_link();
  EXPECT_EQ(served.server().link(), second);
  EXPECT_NE(second, link);
}

TEST(Servers, AnswerOneRequestAfterAnotherOnAConnection) {
  Served served;
  const Browser browser(served.server());
  RawClient client(served.port());
  const Received got = client.ask(browser.get("/a%20b?x=1&y=2"));
  EXPECT_EQ(got.status, 200);
  EXPECT_EQ(got.content, "GET /a b x=1 y=2 ");
  EXPECT_EQ(got.field("Connection"), "keep-alive");
  EXPECT_EQ(got.field("X-Content-Type-Options"), "nosniff");
  EXPECT_EQ(got.field("Cache-Control"), "no-store");
  EXPECT_EQ(got.field("Server"), "");
  EXPECT_EQ(client.ask(browser.post("/api/find", "{\"a\": 1}")).content,
            "POST /api/find {\"a\": 1}");
  const Received head = client.ask(browser.request("HEAD", "/a", ""), true);
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.field("Content-Length"), "7");
  EXPECT_EQ(client.ask(browser.get("/missing")).status, 404);
  EXPECT_EQ(client.ask(browser.get("/a", "If-None-Match: \"e\"\r\n")).status, 304);
  client.send(browser.get("/1") + browser.post("/2", "two") + browser.get("/3"));
  EXPECT_EQ(client.receive().content, "GET /1 ");
  EXPECT_EQ(client.receive().content, "POST /2 two");
  EXPECT_EQ(client.receive().content, "GET /3 ");
  EXPECT_EQ(client.ask(browser.get("/last", "Connection: close\r\n")).field("Connection"), "close");
  EXPECT_TRUE(client.is_closed());
}

TEST(Servers, TakeBodiesThatWait) {
  Served served;
  const Browser browser(served.server());
  RawClient client(served.port());
  const Received proceed = client.ask(browser.post_head("/p", 4, "Expect: 100-continue\r\n"));
  EXPECT_EQ(proceed.status, 100);
  EXPECT_EQ(client.ask("{  }").content, "POST /p {  }");
  const std::string large(4U << 20U, 'l');
  EXPECT_EQ(client.ask(browser.post("/l", large)).content, "POST /l " + large);
  const std::string head =
      browser.request("POST", "/c",
                      "Origin: http://" + browser.host() +
                          "\r\nContent-Type: application/json\r\nTransfer-Encoding: chunked\r\n");
  EXPECT_EQ(client.ask(head + "0\r\n\r\n").status, 411);
  EXPECT_TRUE(comes_true([&] { return served.server().counts().bodies_bytes == 0; }));
}

TEST(Servers, AnswerFilesByThemselves) {
  Served served({.files = small_page("files")});
  const Browser browser(served.server());
  RawClient client(served.port());
  const Received index = client.ask(browser.get("/"));
  EXPECT_EQ(index.content, "<!doctype html>");
  EXPECT_EQ(index.field("Cache-Control"), "no-store");
  EXPECT_NE(index.field("Content-Security-Policy").find("script-src 'self'"), std::string::npos);
  const Received script =
      client.ask(browser.get("/index-DkX3_9aQ.js", "Accept-Encoding: gzip\r\n"));
  EXPECT_EQ(script.field("Content-Encoding"), "gzip");
  EXPECT_EQ(script.field("Cache-Control"), "private, max-age=31536000, immutable");
  EXPECT_LT(script.content.size(), 100U);
  EXPECT_EQ(client
                .ask(browser.get("/index-DkX3_9aQ.js", "Accept-Encoding: gzip\r\nIf-None-Match: " +
                                                           script.field("ETag") + "\r\n"))
                .status,
            304);
  EXPECT_EQ(served.asks(), 0);
  // A request reaches the handler if its path names no file or if it is a POST request.
  EXPECT_EQ(client.ask(browser.get("/other.js")).content, "GET /other.js ");
  EXPECT_EQ(client.ask(browser.post("/", "x")).content, "POST / x");
  EXPECT_EQ(
      RawClient(served.port()).ask("GET / HTTP/1.1\r\nHost: " + browser.host() + "\r\n\r\n").status,
      403);
}

TEST(Servers, TellNothingOfAHandlersFailure) {
  Served served;
  const Browser browser(served.server());
  RawClient client(served.port());
  for (const std::string path : {"/throws", "/throws_odd", "/unsound"}) {
    const Received failed = client.ask(browser.get(path));
    EXPECT_EQ(failed.status, 500) << path;
    EXPECT_EQ(failed.content.find("secret words"), std::string::npos);
    EXPECT_EQ(failed.field("Set-Cookie"), "");
  }
  EXPECT_EQ(client.ask(browser.get("/a")).status, 200);
  ASSERT_EQ(served.complaints().size(), 3U);
  EXPECT_NE(served.complaints().at(0).find("secret words"), std::string::npos);
}

TEST(Servers, SlowAnswersHoldUpNoOther) {
  Served served({.files = small_page("slow"), .threads = 3});
  const Browser browser(served.server());
  RawClient slow_1(served.port());
  RawClient slow_2(served.port());
  slow_1.send(browser.get("/slow"));
  slow_2.send(browser.get("/slow"));
  served.gate.wait_for(2);
  RawClient quick(served.port());
  for (int i = 0; i < 20; ++i)
    EXPECT_EQ(quick.ask(browser.get("/quick")).status, 200);
  // If all threads are busy, files and events are still served.
  RawClient slow_3(served.port());
  slow_3.send(browser.get("/slow"));
  served.gate.wait_for(3);
  EXPECT_EQ(quick.ask(browser.get("/")).status, 200);
  RawClient stream(served.port());
  stream.send(browser.stream());
  served.server().publish("a", "1");
  EXPECT_NE(stream.receive_until("data: 1\n\n").find("data: 1\n\n"), std::string::npos);
  served.gate.open();
  for (RawClient* slow : {&slow_1, &slow_2, &slow_3})
    EXPECT_EQ(slow->receive().content, "GET /slow ");
}

TEST(Servers, StreamEvents) {
  ServerOptions options;
  options.limits.streams_max = 2;
  options.limits.stream_comment_s = 0.05;
  Served served(options);
  const Browser browser(served.server());
  served.server().publish("gallery", "old");
  served.server().publish("gallery", "{\n}");
  served.server().publish("other", "2");
  RawClient first(served.port());
  const Received head = first.ask(browser.stream());
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.field("Content-Type"), "text/event-stream");
  EXPECT_EQ(head.field("Content-Length"), "");
  EXPECT_EQ(first.receive_until("data: 2\n\n"),
            "retry: 1000\n\nevent: gallery\ndata: {\ndata: }\n\nevent: other\ndata: 2\n\n");
  EXPECT_NE(first.receive_until(":\n\n:\n\n").find(":\n\n:\n\n"), std::string::npos);
  RawClient second(served.port());
  second.send(browser.stream());
  second.receive_until("data: 2\n\n");
  served.server().publish("gallery", "new");
  EXPECT_NE(first.receive_until("data: new\n\n").find("event: gallery\ndata: new\n\n"),
            std::string::npos);
  EXPECT_NE(second.receive_until("data: new\n\n").find("event: gallery\ndata: new\n\n"),
            std::string::npos);
  EXPECT_EQ(served.server().counts().streams, 2U);
  EXPECT_EQ(RawClient(served.port()).ask(browser.stream()).status, 503);
  // A request without Origin and Sec-Fetch-Site gets no stream.
  EXPECT_EQ(RawClient(served.port()).ask(browser.get("/api/events")).status, 403);
  { const RawClient gone = std::move(second); }
  EXPECT_TRUE(comes_true([&] { return served.server().counts().streams == 1; }));
  // If the client sends bytes during a stream, the server ends the stream.
  first.send("GET / HTTP/1.1\r\n\r\n");
  EXPECT_TRUE(first.is_closed(10'000));
  EXPECT_TRUE(comes_true([&] { return served.server().counts().streams == 0; }));
}

TEST(Servers, ComeBackWithTheSamePortAndSecret) {
  const std::string secret = new_secret();
  std::optional<Served> served(std::in_place, ServerOptions{.secret = secret});
  const std::uint16_t port = served->port();
  const Browser browser(served->server());
  RawClient client(port);
  EXPECT_EQ(client.ask(browser.get("/a")).status, 200);
  RawClient stream(port);
  stream.send(browser.stream());
  stream.receive_until("retry");
  RawClient slow(port);
  slow.send(browser.get("/slow"));
  served->gate.wait_for(1);
  std::thread stopping([&] { served->server().stop(); });
  served->gate.open();
  stopping.join();
  served->server().stop();
  EXPECT_TRUE(client.is_closed());
  EXPECT_TRUE(stream.is_closed(10'000));
  EXPECT_EQ(served->server().counts().connections, 0U);
  EXPECT_FALSE(RawClient(port).is_connected());
  served->server().publish("a", "nobody hears");
  served.reset();
  served.emplace(ServerOptions{.port = port, .secret = secret});
  EXPECT_EQ(RawClient(port).ask(browser.get("/a")).status, 200);
  served.reset();
  served.emplace(ServerOptions{.port = port});
  EXPECT_EQ(RawClient(port).ask(browser.get("/a")).status, 403);
}

TEST(Servers, SayThatAPortIsTaken) {
  Served served;
  try {
    Served other({.port = served.port()});
    FAIL();
  } catch (const base::Error& error) {
    EXPECT_EQ(error.exit_code(), base::ExitCode::conflict);
    EXPECT_NE(std::string(error.what()).find(std::to_string(served.port())), std::string::npos);
  }
}

TEST(Servers, GiveNoSocketToOtherProcesses) {
  Served served;
  const Browser browser(served.server());
  RawClient client(served.port());
  client.ask(browser.get("/a"));
  int sockets = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    const int descriptor = std::atoi(entry.path().filename().c_str());
    struct stat status {};
    if (::fstat(descriptor, &status) != 0 || !S_ISSOCK(status.st_mode)) continue;
    sockaddr_storage address{};
    socklen_t size = sizeof address;
    if (::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size) != 0) continue;
    if (address.ss_family != AF_INET) continue;
    ++sockets;
    EXPECT_NE(::fcntl(descriptor, F_GETFD) & FD_CLOEXEC, 0);
  }
  EXPECT_GE(sockets, 3);
}

}  // namespace
}  // namespace sleight::web
