// Goal: the guard passes only requests that the page sends from an authorized browser. Method:
// change one part of a valid request at a time, and check whether the guard refuses the request.
#include "clients/web/guard.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace sleight::web {
namespace {

constexpr std::string_view k_way_in = "Ask for a link.";

class Guarding : public ::testing::Test {
 protected:
  using Fields = std::vector<std::pair<std::string, std::string>>;

  struct Request {
    std::string method = "GET";
    std::string target = "/api/gallery";
    unsigned version = 11;
    Fields fields{};
  };

  /// Returns a request as an authorized browser sends it.
  Request good() const { return {.fields = {{"Host", "127.0.0.1:7000"}, {"Cookie", cookie()}}}; }
  Request post() const {
    Request request = good();
    request.method = "POST";
    request.target = "/api/find";
    request.fields.insert(request.fields.end(), {{"Origin", "http://127.0.0.1:7000"},
                                                 {"Content-Type", "application/json"},
                                                 {"Content-Length", "2"}});
    return request;
  }
  std::string cookie() const { return "sleight-7000=" + keys_.secret(); }

  static Request with(Request request, const std::string& name, const std::string& value) {
    request.fields.emplace_back(name, value);
    return request;
  }
  static Request but(Request request, const std::string& name, const std::string& value) {
    std::erase_if(request.fields, [&](const auto& field) { return field.first == name; });
    return with(std::move(request), name, value);
  }
  static Request without(Request request, const std::string& name) {
    std::erase_if(request.fields, [&](const auto& field) { return field.first == name; });
    return request;
  }
  static Request to(Request request, const std::string& target) {
    request.target = target;
    return request;
  }
  static Request by(Request request, const std::string& method) {
    request.method = method;
    return request;
  }

  base::Result<Passed, Refusal> judge(const Request& request) {
    Head head{.method = request.method, .target = request.target, .version = request.version};
    for (const auto& [name, value] : request.fields)
      head.fields.push_back({.name = name, .value = value});
    return guard_.judge(head);
  }
  /// Returns the status of the refusal, or 0 if the request passes.
  unsigned refused(const Request& request) {
    const auto judged = judge(request);
    if (judged) return 0;
    const std::string words = fmt::format("{} {}", judged.error().error, judged.error().what_to_do);
    EXPECT_EQ(words.find("127.0.0.2"), std::string::npos);
    EXPECT_EQ(words.find(keys_.secret()), std::string::npos);
    EXPECT_FALSE(judged.error().error.empty());
    EXPECT_FALSE(judged.error().what_to_do.empty());
    EXPECT_EQ(judged.error().is_json, request.target.starts_with("/api/"));
    return judged.error().status;
  }

  Keys keys_;
  Guard guard_{{.port = 7000, .hosts = {"localhost:8080"}, .way_in = std::string(k_way_in)}, keys_};
};

TEST_F(Guarding, PassesWhatOurPageAsks) {
  const auto judged = judge(to(good(), "/api/archives/0/animations?names=0.250,0.300"));
  ASSERT_TRUE(judged);
  EXPECT_EQ(judged.value().way, Way::answer);
  EXPECT_EQ(judged.value().ask.method, Method::get);
  EXPECT_EQ(judged.value().ask.path, "/api/archives/0/animations");
  EXPECT_EQ(judged.value().ask.parameter("names"), "0.250,0.300");
  EXPECT_FALSE(judged.value().is_head);
  EXPECT_FALSE(judged.value().has_body);

  const auto posted = judge(post());
  ASSERT_TRUE(posted);
  EXPECT_EQ(posted.value().ask.method, Method::post);
  EXPECT_TRUE(posted.value().has_body);

  const auto head = judge(by(good(), "HEAD"));
  ASSERT_TRUE(head);
  EXPECT_TRUE(head.value().is_head);
  EXPECT_EQ(head.value().ask.method, Method::get);
}

TEST_F(Guarding, KnowsItsHosts) {
  for (const std::string host : {"127.0.0.1:7000", "localhost:7000", "localhost:8080"})
    EXPECT_EQ(refused(but(good(), "Host", host)), 0U) << host;
  for (const std::string host :
       {"", "127.0.0.1", "localhost", "[::1]:7000", "127.0.0.1:7001", "127.0.0.1:70000",
        "evil.example:7000", "127.0.0.2:7000", "127.0.0.1:7000.evil.example", "evil.example",
        "LOCALHOST:7000", "localhost.:7000", "127.1:7000", "user@127.0.0.1:7000",
        "127.0.0.1:7000,127.0.0.1:7000", "127.0.0.1:8080"}) {
    EXPECT_EQ(refused(but(good(), "Host", host)), 421U) << host;
  }
  EXPECT_EQ(refused(without(good(), "Host")), 400U);
  EXPECT_EQ(refused(with(good(), "Host", "127.0.0.1:7000")), 400U);
  EXPECT_EQ(refused(with(good(), "hOST", "evil.example")), 400U);
  Request old = without(good(), "Host");
  old.version = 10;
  EXPECT_EQ(refused(old), 400U);
}

TEST_F(Guarding, KnowsItsMethods) {
  for (const std::string method :
       {"PUT", "DELETE", "OPTIONS", "CONNECT", "TRACE", "PATCH", "get", "G"})
    EXPECT_EQ(refused(by(good(), method)), 405U) << method;
}

TEST_F(Guarding, RefusesOtherOrigins) {
  for (const std::string origin :
       {"http://evil.example", "null", "", "https://127.0.0.1:7000", "http://127.0.0.1:7001",
        "http://127.0.0.1", "http://127.0.0.1:7000/", "http://localhost:7000",
        "http://127.0.0.1:7000.evil.example", "127.0.0.1:7000"}) {
    EXPECT_EQ(refused(with(good(), "Origin", origin)), 403U) << origin;
    EXPECT_EQ(refused(but(post(), "Origin", origin)), 403U) << origin;
  }
  EXPECT_EQ(refused(with(good(), "Origin", "http://127.0.0.1:7000")), 0U);
  EXPECT_EQ(refused(with(but(good(), "Host", "localhost:8080"), "Origin", "http://localhost:8080")),
            0U);
  EXPECT_EQ(refused(without(post(), "Origin")), 403U);
  EXPECT_EQ(refused(with(post(), "Origin", "http://127.0.0.1:7000")), 400U);
}

TEST_F(Guarding, RefusesWhatABrowserSaysComesFromElsewhere) {
  EXPECT_EQ(refused(with(good(), "Sec-Fetch-Site", "same-origin")), 0U);
  EXPECT_EQ(refused(with(good(), "Sec-Fetch-Site", "none")), 0U);
  for (const std::string site : {"cross-site", "same-site", "", "anything"}) {
    EXPECT_EQ(refused(with(good(), "Sec-Fetch-Site", site)), 403U) << site;
    EXPECT_EQ(refused(with(post(), "Sec-Fetch-Site", site)), 403U) << site;
    // If the user followed a link on another site, the request is refused too, unless the link
    // contains a token.
    const Request led =
        with(with(with(to(good(), "/"), "Sec-Fetch-Site", site), "Sec-Fetch-Mode", "navigate"),
             "Sec-Fetch-Dest", "document");
    EXPECT_EQ(refused(led), 403U) << site;
  }
  EXPECT_EQ(refused(with(with(good(), "Sec-Fetch-Site", "none"), "Sec-Fetch-Site", "none")), 400U);
}

TEST_F(Guarding, WantsItsCookie) {
  const std::string secret = keys_.secret();
  EXPECT_EQ(refused(without(good(), "Cookie")), 403U);
  for (const std::string& cookies :
       {std::string(""), std::string("a=b"), "sleight-7001=" + secret,
        "sleight-7000=" + secret + "0", "sleight-7000=" + secret.substr(1),
        std::string("sleight-7000="), std::string("sleight-7000"), "xsleight-7000=" + secret,
        "a=sleight-7000=" + secret, "sleight-7000=\"" + secret + "\"", secret,
        "Sleight-7000=" + secret, "sleight-7000 =" + secret}) {
    EXPECT_EQ(refused(but(good(), "Cookie", cookies)), 403U) << cookies;
  }
  for (const std::string& cookies :
       {"a=b; " + cookie(), cookie() + "; a=b", "sleight-7000=00; " + cookie(),
        ";; " + cookie() + ";", cookie() + "; sleight-7000=00"}) {
    EXPECT_EQ(refused(but(good(), "Cookie", cookies)), 0U) << cookies;
  }
  EXPECT_EQ(refused(with(good(), "Cookie", cookie())), 400U);
  EXPECT_EQ(judge(without(good(), "Cookie")).error().what_to_do, k_way_in);
  EXPECT_EQ(guard_.cookie(), cookie() + "; HttpOnly; SameSite=Strict; Path=/");
}

TEST_F(Guarding, TakesJsonAlone) {
  for (const std::string type :
       {"application/json", "Application/JSON", "application/json; charset=utf-8"})
    EXPECT_EQ(refused(but(post(), "Content-Type", type)), 0U) << type;
  for (const std::string type :
       {"text/plain", "application/x-www-form-urlencoded", "", "application/jsonx",
        "multipart/form-data; boundary=a", "text/plain; application/json"}) {
    EXPECT_EQ(refused(but(post(), "Content-Type", type)), 415U) << type;
  }
  EXPECT_EQ(refused(without(post(), "Content-Type")), 415U);
  EXPECT_EQ(refused(with(post(), "Content-Type", "text/plain")), 400U);
}

TEST_F(Guarding, WantsOneLength) {
  EXPECT_EQ(refused(with(post(), "Content-Length", "2")), 400U);
  EXPECT_EQ(refused(with(post(), "Transfer-Encoding", "chunked")), 400U);
  const Request chunked = but(without(post(), "Content-Length"), "Transfer-Encoding", "chunked");
  EXPECT_EQ(refused(chunked), 411U);
  EXPECT_EQ(refused(with(chunked, "Transfer-Encoding", "chunked")), 400U);
  for (const std::string coding : {"", "identity", "gzip, chunked", "xchunked"})
    EXPECT_EQ(refused(but(chunked, "Transfer-Encoding", coding)), 411U) << coding;
  for (const std::string length : {"", "-1", "+2", "0x2", "2,2", "2 2", "99999999999999999999"})
    EXPECT_EQ(refused(but(post(), "Content-Length", length)), 400U) << length;
  EXPECT_EQ(refused(but(post(), "Content-Length", "0")), 0U);
  EXPECT_FALSE(judge(but(post(), "Content-Length", "00")).value().has_body);
  EXPECT_FALSE(judge(without(post(), "Content-Length")).value().has_body);
  EXPECT_EQ(refused(with(good(), "Content-Length", "0")), 0U);
  EXPECT_EQ(refused(with(good(), "Content-Length", "1")), 400U);
  EXPECT_EQ(refused(with(good(), "Transfer-Encoding", "chunked")), 411U);
}

TEST_F(Guarding, ProceedsWhereThatIsExpected) {
  EXPECT_TRUE(judge(with(post(), "Expect", "100-continue")).value().wants_continue);
  EXPECT_FALSE(judge(post()).value().wants_continue);
  EXPECT_FALSE(judge(with(good(), "Expect", "100-continue")).value().wants_continue);
  EXPECT_EQ(refused(with(post(), "Expect", "something")), 417U);
}

TEST_F(Guarding, StreamsAreForOurPage) {
  const Request stream = to(good(), "/api/events");
  EXPECT_EQ(refused(stream), 403U);
  const auto by_origin = judge(with(stream, "Origin", "http://127.0.0.1:7000"));
  ASSERT_TRUE(by_origin);
  EXPECT_EQ(by_origin.value().way, Way::stream);
  EXPECT_EQ(judge(with(stream, "Sec-Fetch-Site", "same-origin")).value().way, Way::stream);
  EXPECT_EQ(refused(with(stream, "Sec-Fetch-Site", "none")), 403U);
  EXPECT_EQ(refused(with(stream, "Origin", "http://evil.example")), 403U);
  EXPECT_EQ(refused(to(post(), "/api/events")), 405U);
}

TEST_F(Guarding, ALinkLetsInOnce) {
  const std::string token = keys_.new_token();
  const Request outside = without(good(), "Cookie");
  EXPECT_EQ(refused(to(outside, "/?token=" + token + "0")), 403U);
  EXPECT_EQ(refused(to(outside, "/?token=")), 403U);
  EXPECT_EQ(refused(to(outside, "/?tokens=" + token)), 403U);
  EXPECT_EQ(refused(to(outside, "/a?token=" + token)), 403U);
  EXPECT_EQ(refused(by(to(outside, "/?token=" + token), "HEAD")), 403U);
  EXPECT_EQ(refused(by(to(outside, "/?token=" + token), "POST")), 403U);
  EXPECT_EQ(refused(but(to(outside, "/?token=" + token), "Host", "evil.example:7000")), 421U);
  EXPECT_EQ(refused(with(to(outside, "/?token=" + token), "Origin", "http://evil.example")), 403U);
  const auto judged = judge(to(outside, "/?token=" + token));
  ASSERT_TRUE(judged);
  EXPECT_EQ(judged.value().way, Way::let_in);
  EXPECT_EQ(refused(to(outside, "/?token=" + token)), 403U);
}

TEST_F(Guarding, ALinkOnAnotherSiteLetsInByAPage) {
  const std::string token = keys_.new_token();
  const auto led = [&](const std::string& mode, const std::string& destination) {
    return with(with(with(to(without(good(), "Cookie"), "/?token=" + token), "Sec-Fetch-Site",
                          "cross-site"),
                     "Sec-Fetch-Mode", mode),
                "Sec-Fetch-Dest", destination);
  };
  EXPECT_EQ(refused(led("navigate", "iframe")), 403U);
  EXPECT_EQ(refused(led("no-cors", "image")), 403U);
  EXPECT_EQ(refused(led("cors", "empty")), 403U);
  EXPECT_EQ(refused(by(led("navigate", "document"), "HEAD")), 403U);
  const auto judged = judge(led("navigate", "document"));
  ASSERT_TRUE(judged);
  EXPECT_EQ(judged.value().way, Way::let_in_by_page);
  EXPECT_EQ(refused(led("navigate", "document")), 403U);
}

TEST_F(Guarding, OneThatIsInNeedsNoToken) {
  const std::string token = keys_.new_token();
  EXPECT_EQ(judge(to(good(), "/?token=" + token)).value().way, Way::go_home);
  EXPECT_EQ(judge(to(good(), "/?token=used")).value().way, Way::go_home);
  EXPECT_TRUE(keys_.use(token));
}

TEST_F(Guarding, KnowsWhoTakesGzip) {
  const auto takes = [&](const std::string& value) {
    return judge(with(good(), "Accept-Encoding", value)).value().ask.accepts_gzip;
  };
  EXPECT_FALSE(judge(good()).value().ask.accepts_gzip);
  EXPECT_TRUE(takes("gzip"));
  EXPECT_TRUE(takes("br, GZIP;q=0.5"));
  EXPECT_TRUE(takes("deflate,gzip"));
  EXPECT_FALSE(takes(""));
  EXPECT_FALSE(takes("br"));
  EXPECT_FALSE(takes("xgzip"));
  EXPECT_FALSE(takes("gzip;q=0"));
  EXPECT_FALSE(takes("gzip; q=0.000"));
}

}  // namespace
}  // namespace sleight::web
