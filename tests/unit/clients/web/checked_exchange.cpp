#include "tests/unit/clients/web/checked_exchange.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <optional>
#include <utility>

#include "clients/web/reply.h"
#include "clients/web/target.h"
#include "common/base/check.h"

namespace sleight::web::testing {
namespace {

std::string lower(std::string_view text) {
  std::string small(text);
  for (char& c : small)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return small;
}

std::string trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t'))
    text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t'))
    text.remove_suffix(1);
  return std::string(text);
}

/// Removes all lines up to the first empty line from `bytes`, and returns them without the empty
/// line. Returns nothing if there is no empty line.
std::optional<std::vector<std::string>> take_lines(std::string_view& bytes) {
  std::vector<std::string> lines;
  while (true) {
    const std::size_t end = bytes.find("\r\n");
    if (end == std::string_view::npos) return std::nullopt;
    const std::string_view line = bytes.substr(0, end);
    bytes.remove_prefix(end + 2);
    if (line.empty()) return lines;
    // A line that begins with a blank continues the previous line.
    if ((line.front() == ' ' || line.front() == '\t') && lines.size() > 1) {
      lines.back() += " " + trimmed(line);
    } else {
      lines.emplace_back(line);
    }
  }
}

std::optional<std::size_t> number_in(std::string_view text) {
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

std::vector<PlainRequest> read_plainly(std::string_view bytes) {
  const std::size_t all = bytes.size();
  const auto lines = take_lines(bytes);
  if (!lines || lines->empty()) return {};
  PlainRequest request;
  const std::string& first = lines->front();
  const std::size_t blank = first.find(' ');
  const std::size_t last = first.rfind(' ');
  if (blank == std::string::npos || last == blank) return {};
  request.method = first.substr(0, blank);
  request.target = first.substr(blank + 1, last - blank - 1);
  const std::string version = first.substr(last + 1);
  if (version != "HTTP/1.1" && version != "HTTP/1.0") return {};
  std::vector<std::string> lengths;
  std::vector<std::string> codings;
  for (std::size_t i = 1; i < lines->size(); ++i) {
    const std::string& line = (*lines)[i];
    const std::size_t colon = line.find(':');
    if (colon == std::string::npos) return {};
    const std::string name = lower(std::string_view(line).substr(0, colon));
    const std::string value = trimmed(std::string_view(line).substr(colon + 1));
    if (name == "host") request.hosts.push_back(value);
    if (name == "cookie") request.cookies.push_back(value);
    if (name == "content-length") lengths.push_back(value);
    if (name == "transfer-encoding") codings.push_back(lower(value));
  }
  if (lengths.size() > 1 || !codings.empty()) return {};
  if (!lengths.empty()) {
    const auto length = number_in(lengths.front());
    if (!length || *length > bytes.size()) return {};
    request.body = bytes.substr(0, *length);
    bytes.remove_prefix(*length);
  }
  request.size = all - bytes.size();
  return {request};
}

namespace {

Answer answer_to(const Passed& passed, const Guard& guard) {
  if (passed.way != Way::answer) return answer_of(passed.way, guard.cookie());
  return {.content = "{}", .etag = "\"a\""};
}

void check_head(std::string_view head) {
  CHECK(head.starts_with("HTTP/1.1 "));
  CHECK(head.ends_with("\r\n\r\n"));
  std::size_t lines = 0;
  for (std::size_t i = 0; i + 1 < head.size(); ++i) {
    const bool is_end = head[i] == '\r';
    CHECK_EQ(is_end, head[i + 1] == '\n');
    if (is_end) ++lines;
  }
  // A sound head has at most 14 lines. A line end within a value would add more lines.
  CHECK_LE(lines, 14U);
}

}  // namespace

Outcome exchange_in_pieces(std::string_view bytes, std::size_t piece) {
  Keys keys(std::string(k_secret), {std::string(k_token)});
  const Guard guard({.port = k_port, .way_in = "Ask for a link."}, keys);
  BodyBudget budget{.bytes_max = k_bodies_bytes_max};
  Outcome outcome;
  {
    Intake intake(guard, k_limits, budget);
    std::string_view rest = bytes;
    while (true) {
      const Step step = intake.step();
      CHECK_LE(budget.bytes, k_bodies_bytes_max);
      Reply reply;
      if (step == Step::more) {
        if (rest.empty()) break;
        const std::span<char> room = intake.room();
        CHECK(!room.empty());
        const std::size_t count = std::min({room.size(), rest.size(), piece});
        std::memcpy(room.data(), rest.data(), count);
        rest.remove_prefix(count);
        intake.got(count);
        continue;
      }
      if (step == Step::proceed) continue;
      if (step == Step::refused) {
        outcome.refused = intake.refusal().status;
        reply.answer = answer_of(intake.refusal());
      } else {
        Passed& passed = intake.passed();
        CHECK_LE(passed.ask.body.size(), k_limits.body_bytes_max);
        reply = {.answer = unless_known(answer_to(passed, guard), passed.if_none_match),
                 .is_head = passed.is_head,
                 .keeps_open = intake.keeps_open()};
        outcome.taken.push_back({.passed = passed, .keeps_open = reply.keeps_open});
      }
      CHECK(is_sound(reply.answer));
      const std::string head = head_text(reply);
      check_head(head);
      outcome.sent += head;
      if (step == Step::refused || !reply.keeps_open ||
          outcome.taken.back().passed.way == Way::stream)
        break;
      intake.next();
    }
  }
  CHECK_EQ(budget.bytes, 0U);
  return outcome;
}

namespace {

void check_passed(const Taken& taken, const PlainRequest& plain) {
  const Passed& passed = taken.passed;
  const Ask& ask = passed.ask;
  CHECK(plain.method == "GET" || plain.method == "HEAD" || plain.method == "POST");
  CHECK_EQ(ask.method == Method::post, plain.method == "POST");
  CHECK_EQ(passed.is_head, plain.method == "HEAD");
  CHECK_EQ(ask.body, plain.body);
  CHECK(ask.body.empty() || ask.method == Method::post);
  CHECK_EQ(plain.hosts.size(), 1U);
  const std::string& host = plain.hosts.front();
  CHECK(host == "127.0.0.1:7000" || host == "localhost:7000");

  CHECK(ask.path.starts_with('/'));
  CHECK(plain.target.starts_with('/'));
  CHECK_LE(plain.target.size(), k_target_bytes_max);
  for (const char c : ask.path) {
    CHECK_GE(static_cast<unsigned char>(c), 0x20);
    CHECK_NE(c, '\\');
  }
  const std::string between = ask.path + "/";
  CHECK_EQ(between.find("/../"), std::string::npos);
  CHECK_EQ(between.find("/./"), std::string::npos);

  const bool has_cookie =
      plain.cookies.size() == 1 && plain.cookies.front().find(k_secret) != std::string::npos;
  const bool is_link = passed.way == Way::let_in || passed.way == Way::let_in_by_page;
  CHECK(has_cookie || is_link);
  if (is_link || passed.way == Way::go_home)
    CHECK(ask.path == "/" && plain.target.find("token=") != std::string::npos);
}

bool is_same(const Ask& a, const Ask& b) {
  return a.method == b.method && a.path == b.path && a.body == b.body &&
         std::ranges::equal(a.parameters, b.parameters, [](const Parameter& x, const Parameter& y) {
           return x.name == y.name && x.value == y.value;
         });
}

}  // namespace

Outcome checked_exchange(std::string_view bytes, std::size_t piece) {
  Outcome whole = exchange_in_pieces(bytes, bytes.size() + 1);
  // Refusals are not compared: if two heads are damaged, the size of the pieces may determine which
  // head is refused.
  const Outcome in_pieces = exchange_in_pieces(bytes, piece);
  CHECK_EQ(whole.taken.size(), in_pieces.taken.size());
  std::string_view rest = bytes;
  for (std::size_t i = 0; i < whole.taken.size(); ++i) {
    CHECK(is_same(whole.taken[i].passed.ask, in_pieces.taken[i].passed.ask));
    CHECK(whole.taken[i].passed.way == in_pieces.taken[i].passed.way);
    const auto plain = read_plainly(rest);
    CHECK_EQ(plain.size(), 1U);
    check_passed(whole.taken[i], plain.front());
    rest.remove_prefix(plain.front().size);
  }
  return whole;
}

}  // namespace sleight::web::testing
