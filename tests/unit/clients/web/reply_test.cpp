// Goal: each answer has all protective headers, and no handler or request can inject another
// header. Method: compare the heads of answers with the expected texts. Use values that contain
// line ends.
#include "clients/web/reply.h"
#include "common/json/value.h"

#include <gtest/gtest.h>

#include <string>

namespace sleight::web {
namespace {

TEST(Replies, HaveTheseHeads) {
  const Reply reply{.answer = {.content = "{}", .etag = "\"a\"", .fields = {{"Vary", "Accept"}}},
                    .keeps_open = true};
  EXPECT_EQ(head_text(reply),
            "HTTP/1.1 200 OK\r\n"
            "Content-Type: application/json\r\n"
            "Content-Length: 2\r\n"
            "Cache-Control: no-store\r\n"
            "ETag: \"a\"\r\n"
            "Vary: Accept\r\n"
            "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; "
            "img-src 'self' blob: data:; connect-src 'self'; font-src 'none'; base-uri 'none'; "
            "form-action 'none'; frame-ancestors 'none'\r\n"
            "X-Content-Type-Options: nosniff\r\n"
            "Referrer-Policy: no-referrer\r\n"
            "Cross-Origin-Opener-Policy: same-origin\r\n"
            "Cross-Origin-Resource-Policy: same-origin\r\n"
            "Connection: keep-alive\r\n"
            "\r\n");
  const std::string stream = stream_head_text();
  EXPECT_NE(stream.find("Content-Security-Policy: default-src 'none'"), std::string::npos);
  EXPECT_NE(stream.find("Cache-Control: no-store\r\n"), std::string::npos);
  EXPECT_NE(head_text({.answer = {.cache = Cache::immutable}})
                .find("Cache-Control: private, max-age=31536000, immutable\r\n"),
            std::string::npos);
}

TEST(Replies, KeepTheirContentForHead) {
  const Reply reply{.answer = {.content = "1234"}, .is_head = true};
  EXPECT_NE(head_text(reply).find("Content-Length: 4\r\n"), std::string::npos);
  EXPECT_EQ(content_of(reply).size(), 0U);
}

TEST(Replies, OfHandlersAreLookedAt) {
  EXPECT_TRUE(is_sound({}));
  EXPECT_TRUE(is_sound({.status = 404, .fields = {{"Content-Disposition", "attachment"}}}));
  EXPECT_FALSE(is_sound({.status = 199}));
  EXPECT_FALSE(is_sound({.status = 600}));
  EXPECT_FALSE(is_sound({.status = 204}));
  EXPECT_FALSE(is_sound({.type = ""}));
  EXPECT_FALSE(is_sound({.type = "a\r\nSet-Cookie: b"}));
  EXPECT_FALSE(is_sound({.etag = "\"a\n\""}));
  EXPECT_FALSE(is_sound({.fields = {{"X", "a\r\nb"}}}));
  EXPECT_FALSE(is_sound({.fields = {{"X:", "a"}}}));
  EXPECT_FALSE(is_sound({.fields = {{"", "a"}}}));
  EXPECT_FALSE(is_sound({.fields = {{"A B", "a"}}}));
}

TEST(Replies, ErrorsAreTwoSentences) {
  const Answer answer = error_answer(404, "no \"such\" \n\xff", "look");
  EXPECT_EQ(answer.status, 404U);
  const auto json = json::Value::parse(answer.content.text());
  EXPECT_EQ(json["error"], "no \"such\" \n\xef\xbf\xbd");
  EXPECT_EQ(json["what_to_do"], "look");

  const Refusal refusal{405, "a", "b", true};
  EXPECT_EQ(json::Value::parse(answer_of(refusal).content.text())["error"], "a");
  EXPECT_EQ(answer_of(refusal).fields.at(0).name, "Allow");
  const Answer plain = answer_of(Refusal{403, "a", "b"});
  EXPECT_EQ(plain.content.text(), "a\nb\n");
  EXPECT_EQ(plain.type, "text/plain; charset=utf-8");
}

TEST(Replies, LetIn) {
  const Answer by_redirect = answer_of(Way::let_in, "c=1");
  EXPECT_EQ(by_redirect.status, 303U);
  const std::string head = head_text({.answer = by_redirect});
  EXPECT_NE(head.find("Location: /\r\n"), std::string::npos);
  EXPECT_NE(head.find("Set-Cookie: c=1\r\n"), std::string::npos);
  const Answer by_page = answer_of(Way::let_in_by_page, "c=1");
  EXPECT_EQ(by_page.status, 200U);
  EXPECT_NE(head_text({.answer = by_page}).find("Set-Cookie: c=1\r\n"), std::string::npos);
  EXPECT_EQ(head_text({.answer = answer_of(Way::go_home, "c=1")}).find("Set-Cookie"),
            std::string::npos);
}

TEST(Replies, WhatIsKnownIsNotSentAgain) {
  const Answer answer{.content = "text", .etag = "\"a\""};
  EXPECT_EQ(unless_known(answer, "").status, 200U);
  EXPECT_EQ(unless_known(answer, "\"b\"").status, 200U);
  EXPECT_EQ(unless_known(answer, "a").status, 200U);
  for (const std::string tags : {"\"a\"", "W/\"a\"", "\"b\", \"a\"", "\"b\",W/\"a\" , \"c\""}) {
    const Answer known = unless_known(answer, tags);
    EXPECT_EQ(known.status, 304U) << tags;
    EXPECT_EQ(head_text({.answer = known}).find("Content-Length"), std::string::npos);
    EXPECT_EQ(content_of({.answer = known}).size(), 0U);
  }
  EXPECT_EQ(unless_known({.status = 404, .etag = "\"a\""}, "\"a\"").status, 404U);
  EXPECT_EQ(unless_known({.content = "text"}, "").status, 200U);
}

TEST(Replies, EventsHaveALineOfDataEach) {
  EXPECT_EQ(event_text("gallery", "{}"), "event: gallery\ndata: {}\n\n");
  EXPECT_EQ(event_text("a", ""), "event: a\ndata: \n\n");
  EXPECT_EQ(event_text("a", "1\n2\r\n3\r4"), "event: a\ndata: 1\ndata: 2\ndata: 3\ndata: 4\n\n");
  EXPECT_EQ(event_text("a", "1\n\nevent: b"), "event: a\ndata: 1\ndata: \ndata: event: b\n\n");
  EXPECT_EQ(event_text("a", "1\n"), "event: a\ndata: 1\ndata: \n\n");
}

}  // namespace
}  // namespace sleight::web
