#include "clients/web/intake.h"

#include <algorithm>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/error.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <optional>
#include <utility>

#include "common/base/check.h"

namespace sleight::web {
namespace {

namespace http = boost::beast::http;
using Parser = http::request_parser<http::string_body>;

/// Bytes per read: few for heads, so that connections without a request use little memory.
constexpr std::size_t k_head_piece_bytes = 4U << 10U;

std::string_view plain(boost::beast::string_view text) {
  return {text.data(), text.size()};
}

Head head_of(const Parser::value_type& message) {
  Head head{.method = plain(message.method_string()),
            .target = plain(message.target()),
            .version = message.version()};
  for (const auto& field : message)
    head.fields.push_back({.name = plain(field.name_string()), .value = plain(field.value())});
  return head;
}

Refusal refusal_of(const boost::beast::error_code& error) {
  if (error == http::error::header_limit || error == http::error::buffer_overflow)
    return {431, "The request's head is too long.", "Delete this site's cookies, and try again."};
  if (error == http::error::body_limit)
    return {413, "The request's content is too long.", "Send less at once."};
  return {400, "The request is not valid HTTP/1.1.", "Use a browser, or curl."};
}

}  // namespace

struct Intake::Impl {
  Impl(const Guard& judging, const IntakeLimits& bounds, BodyBudget& bodies)
      : guard(judging), limits(bounds), budget(bodies) {
    begin();
  }
  ~Impl() { hold(0); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void begin() {
    hold(0);
    parser.emplace();
    // The parser's own limit only counts unparsed bytes; the intake's limit counts all bytes.
    parser->header_limit(k_buffer_bytes);
    head_bytes = 0;
    parser->body_limit(limits.body_bytes_max);
    parser->eager(false);
    passed.reset();
    has_proceeded = false;
  }

  /// Counts the body's bytes; returns false if all bodies together exceed the budget.
  bool hold(std::size_t bytes) {
    budget.bytes += bytes;
    budget.bytes -= held;
    held = bytes;
    return budget.bytes <= budget.bytes_max;
  }

  Step refuse(const Refusal& why) {
    refusal = why;
    refusal->is_json = refusal->is_json || (passed && passed->ask.path.starts_with("/api/"));
    hold(0);
    parser->get().body() = {};
    return Step::refused;
  }

  /// Asks the guard about the complete head. Returns none if the body must be read first.
  std::optional<Step> judge() {
    auto judged = guard.judge(head_of(parser->get()));
    if (!judged) return refuse(judged.error());
    passed = std::move(judged).value();
    // The guard and the parser read the length independently.
    if (passed->has_body == parser->is_done()) return refuse(refusal_of(http::error::bad_value));
    if (parser->is_done()) return Step::whole;
    if (!hold(parser->content_length().value_or(0)))
      return refuse({503, "This server is busy.", "Try again later."});
    parser->eager(true);
    return std::nullopt;
  }

  const Guard& guard;
  IntakeLimits limits;
  BodyBudget& budget;
  boost::beast::flat_buffer buffer{k_buffer_bytes};
  std::optional<Parser> parser;
  std::optional<Passed> passed;
  std::optional<Refusal> refusal;
  std::size_t head_bytes = 0;
  std::size_t held = 0;
  bool has_proceeded = false;
};

Intake::Intake(const Guard& guard, const IntakeLimits& limits, BodyBudget& budget)
    : impl_(std::make_unique<Impl>(guard, limits, budget)) {
  CHECK_LT(limits.head_bytes_max, k_buffer_bytes);
}

Intake::~Intake() = default;

std::span<char> Intake::room() {
  const std::size_t left = k_buffer_bytes - impl_->buffer.size();
  CHECK_GT(left, 0U);
  const auto room =
      impl_->buffer.prepare(impl_->passed ? left : std::min(left, k_head_piece_bytes));
  return {static_cast<char*>(room.data()), room.size()};
}

void Intake::got(std::size_t count) {
  impl_->buffer.commit(count);
}

Step Intake::step() {
  Impl& self = *impl_;
  if (self.refusal) return Step::refused;
  Parser& parser = *self.parser;
  while (true) {
    if (self.passed && parser.is_done()) {
      self.passed->ask.body = std::move(parser.get().body());
      return Step::whole;
    }
    if (self.buffer.size() == 0) {
      if (!self.passed || !self.passed->wants_continue || self.has_proceeded) return Step::more;
      self.has_proceeded = true;
      return Step::proceed;
    }
    boost::beast::error_code error;
    const std::size_t used = parser.put(self.buffer.data(), error);
    self.buffer.consume(used);
    if (!self.passed) {
      self.head_bytes += used;
      const bool is_short = error == http::error::need_more;
      const std::size_t bytes = self.head_bytes + (is_short ? self.buffer.size() : 0);
      if (bytes > self.limits.head_bytes_max)
        return self.refuse(refusal_of(http::error::header_limit));
    }
    if (error == http::error::need_more) {
      if (self.buffer.size() > 0 || used == 0) return Step::more;
    } else if (error) {
      return self.refuse(refusal_of(error));
    }
    if (!self.passed && parser.is_header_done()) {
      if (const auto step = self.judge()) return *step;
    }
  }
}

Passed& Intake::passed() {
  CHECK(impl_->passed.has_value());
  return *impl_->passed;
}

bool Intake::keeps_open() const {
  return impl_->parser->keep_alive();
}

const Refusal& Intake::refusal() const {
  CHECK(impl_->refusal.has_value());
  return *impl_->refusal;
}

void Intake::next() {
  impl_->begin();
}

bool Intake::is_idle() const {
  return !impl_->passed && impl_->buffer.size() == 0 && !impl_->parser->got_some();
}

bool Intake::is_in_body() const {
  return impl_->passed.has_value() && !impl_->parser->is_done();
}

}  // namespace sleight::web
