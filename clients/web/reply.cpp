#include "clients/web/reply.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/beast/http/status.hpp>
#include <iterator>

#include "common/base/check.h"

namespace sleight::web {
namespace {

constexpr std::string_view k_common_fields =
    "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; "
    "img-src 'self' blob: data:; connect-src 'self'; font-src 'none'; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'\r\n"
    "X-Content-Type-Options: nosniff\r\n"
    "Referrer-Policy: no-referrer\r\n"
    "Cross-Origin-Opener-Policy: same-origin\r\n"
    "Cross-Origin-Resource-Policy: same-origin\r\n";

constexpr std::string_view k_text = "text/plain; charset=utf-8";

bool is_plain(std::string_view text) {
  return std::ranges::all_of(
      text, [](char c) { return static_cast<unsigned char>(c) >= 0x20 && c != 0x7f; });
}

bool is_token(std::string_view name) {
  return !name.empty() && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-';
  });
}

std::string_view cache_words(Cache cache) {
  return cache == Cache::immutable ? "private, max-age=31536000, immutable" : "no-store";
}

std::string_view reason_of(unsigned status) {
  const auto reason =
      boost::beast::http::obsolete_reason(boost::beast::http::int_to_status(status));
  return {reason.data(), reason.size()};
}

}  // namespace

std::string head_text(const Reply& reply) {
  const Answer& answer = reply.answer;
  std::string text;
  auto out = std::back_inserter(text);
  fmt::format_to(out, "HTTP/1.1 {} {}\r\n", answer.status, reason_of(answer.status));
  if (answer.status != 304) {
    fmt::format_to(out, "Content-Type: {}\r\nContent-Length: {}\r\n", answer.type,
                   answer.content.view().size());
  }
  fmt::format_to(out, "Cache-Control: {}\r\n", cache_words(answer.cache));
  if (!answer.etag.empty()) fmt::format_to(out, "ETag: {}\r\n", answer.etag);
  for (const Field& field : answer.fields)
    fmt::format_to(out, "{}: {}\r\n", field.name, field.value);
  text += k_common_fields;
  fmt::format_to(out, "Connection: {}\r\n\r\n", reply.keeps_open ? "keep-alive" : "close");
  return text;
}

std::string stream_head_text() {
  std::string text =
      "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nCache-Control: no-store\r\n";
  text += k_common_fields;
  // Milliseconds after which a browser reconnects when its stream has ended.
  text += "Connection: close\r\n\r\nretry: 1000\n\n";
  return text;
}

base::BytesView content_of(const Reply& reply) {
  if (reply.is_head || reply.answer.status == 304) return {};
  return reply.answer.content.view();
}

bool is_sound(const Answer& answer) {
  return answer.status >= 200 && answer.status <= 599 && answer.status != 204 &&
         !answer.type.empty() && is_plain(answer.type) && is_plain(answer.etag) &&
         std::ranges::all_of(answer.fields, [](const Field& field) {
           return is_token(field.name) && is_plain(field.value);
         });
}

Answer answer_of(const Refusal& refusal) {
  Answer answer;
  if (refusal.is_json) {
    answer = error_answer(refusal.status, refusal.error, refusal.what_to_do);
  } else {
    answer = {.status = refusal.status,
              .type = std::string(k_text),
              .content = fmt::format("{}\n{}\n", refusal.error, refusal.what_to_do)};
  }
  if (refusal.status == 405) answer.fields.push_back({"Allow", "GET, HEAD, POST"});
  return answer;
}

Answer answer_of(Way way, const std::string& cookie) {
  Answer answer;
  if (way == Way::let_in_by_page) {
    answer = {.type = "text/html; charset=utf-8",
              .content =
                  "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\">"
                  "<meta http-equiv=\"refresh\" content=\"0; url=/\">"
                  "<title>Sleight</title><p><a href=\"/\">Continue</a></p></html>\n"};
  } else {
    answer = {.status = 303, .type = std::string(k_text), .content = "Continue at /\n"};
    answer.fields.push_back({"Location", "/"});
  }
  if (way != Way::go_home) answer.fields.push_back({"Set-Cookie", cookie});
  return answer;
}

Answer unless_known(Answer answer, std::string_view if_none_match) {
  if (answer.status != 200 || answer.etag.empty()) return answer;
  while (!if_none_match.empty()) {
    const std::size_t end = std::min(if_none_match.find(','), if_none_match.size());
    std::string_view tag = if_none_match.substr(0, end);
    if_none_match.remove_prefix(std::min(end + 1, if_none_match.size()));
    tag.remove_prefix(std::min(tag.find_first_not_of(' '), tag.size()));
    tag = tag.substr(0, tag.find_last_not_of(' ') + 1);
    if (tag.starts_with("W/")) tag.remove_prefix(2);
    if (tag != answer.etag) continue;
    answer.status = 304;
    answer.content = {};
    return answer;
  }
  return answer;
}

std::string event_text(std::string_view name, std::string_view data) {
  CHECK(is_plain(name));
  std::string text = fmt::format("event: {}\n", name);
  // Write one "data:" line per line of data. Readers accept \r\n, \r and \n as line ends.
  while (true) {
    const std::size_t end = std::min(data.find_first_of("\r\n"), data.size());
    fmt::format_to(std::back_inserter(text), "data: {}\n", data.substr(0, end));
    if (end == data.size()) break;
    data.remove_prefix(data.substr(end).starts_with("\r\n") ? end + 2 : end + 1);
  }
  text += "\n";
  return text;
}

}  // namespace sleight::web
