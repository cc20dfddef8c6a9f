#include "clients/web/connection.h"

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/write.hpp>
#include <utility>

#include "common/base/check.h"

namespace sleight::web {
namespace {

namespace asio = boost::asio;
using Error = boost::system::error_code;

/// The peer has a limited time to receive each piece of an answer.
constexpr std::size_t k_piece_bytes = 256U << 10U;

std::chrono::steady_clock::duration seconds(double value) {
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(value));
}

constexpr Refusal k_too_slow{408, "The request took too long to arrive.", "Try again."};

}  // namespace

Connection::Connection(Server::Impl& server, asio::ip::tcp::socket socket, std::uint64_t number,
                       bool is_extra)
    : server_(server),
      socket_(std::move(socket)),
      deadline_(server.loop),
      number_(number),
      stage_since_(std::chrono::steady_clock::now()),
      is_extra_(is_extra),
      intake_(*server.guard,
              {.head_bytes_max = server.options.limits.head_bytes_max,
               .body_bytes_max = server.options.limits.body_bytes_max},
              server.bodies) {}

void Connection::start() {
  set_deadline(server_.options.limits.head_s_max);
  advance();
}

bool Connection::can_make_room() const {
  return stage_ == Stage::lingering || (stage_ == Stage::reading && !is_known_);
}

// ------------------------------------------------------------------------ stages and deadlines

void Connection::set_stage(Stage stage) {
  stage_ = stage;
  stage_since_ = std::chrono::steady_clock::now();
}

void Connection::set_deadline(double value_s) {
  const std::uint64_t number = ++deadline_number_;
  deadline_.expires_after(seconds(value_s));
  deadline_.async_wait([self = shared_from_this(), number](const Error& error) {
    // A replaced deadline may already have expired.
    if (!error && number == self->deadline_number_) self->on_deadline();
  });
}

void Connection::on_deadline() {
  if (stage_ == Stage::reading && !intake_.is_idle()) {
    ++server_.closed;
    // Ends the read in progress.
    Error ignored;
    socket_.cancel(ignored);
    refuse(k_too_slow);
  } else if (stage_ == Stage::reading || stage_ == Stage::lingering) {
    close();
  } else if (stage_ == Stage::writing || stage_ == Stage::streaming) {
    close_as_too_much();
  }
}

void Connection::close_as_too_much() {
  if (stage_ != Stage::closed) ++server_.closed;
  close();
}

void Connection::close() {
  if (stage_ == Stage::closed) return;
  set_stage(Stage::closed);
  Error ignored;
  socket_.close(ignored);
  ++deadline_number_;
  deadline_.cancel(ignored);
  release_answer();
  events_.clear();
  server_.forget(shared_from_this());
}

// ---------------------------------------------------------------------------------------- reading

/// Processes the bytes that have arrived.
void Connection::advance() {
  switch (intake_.step()) {
    case Step::more:
      return read();
    case Step::proceed:
      return proceed();
    case Step::whole:
      return dispatch();
    case Step::refused:
      return refuse(intake_.refusal());
  }
}

void Connection::read() {
  // The idle time, the head and the body each have their own deadline.
  if (!intake_.is_idle() && !std::exchange(is_head_begun_, true))
    set_deadline(server_.options.limits.head_s_max);
  if (intake_.is_in_body() && !std::exchange(is_body_begun_, true)) {
    is_known_ = true;
    set_deadline(server_.options.limits.body_s_max);
  }
  const std::span<char> room = intake_.room();
  socket_.async_read_some(
      asio::buffer(room.data(), room.size()),
      [self = shared_from_this()](const Error& error, std::size_t count) {
        if (self->stage_ != Stage::reading || error == asio::error::operation_aborted) return;
        if (error) return self->close();
        self->intake_.got(count);
        self->advance();
      });
}

void Connection::proceed() {
  constexpr std::string_view k_proceed = "HTTP/1.1 100 Continue\r\n\r\n";
  asio::async_write(socket_, asio::buffer(k_proceed.data(), k_proceed.size()),
                    [self = shared_from_this()](const Error& error, std::size_t) {
                      if (self->stage_ != Stage::reading) return;
                      if (error) return self->close();
                      self->advance();
                    });
}

// -------------------------------------------------------------------------------------- answering

void Connection::dispatch() {
  ++server_.asks;
  is_known_ = true;
  ++deadline_number_;  // handlers have no deadline
  set_stage(Stage::answering);
  Passed& passed = intake_.passed();
  if (passed.way == Way::stream && !passed.is_head) return server_.start_stream(shared_from_this());
  if (passed.way == Way::stream) return answered({.type = "text/event-stream"});
  if (passed.way != Way::answer) return answered(answer_of(passed.way, server_.guard->cookie()));
  if (server_.options.files && passed.ask.method == Method::get) {
    auto found = server_.options.files->find(passed.ask.path, passed.ask.accepts_gzip);
    if (found) return answered(std::move(*found));
  }
  ask_handler(std::move(passed.ask));
}

void Connection::ask_handler(Ask ask) {
  asio::post(*server_.pool, [self = shared_from_this(), ask = std::move(ask)]() mutable {
    Server::Impl& server = self->server_;
    Answer answer = server.answer(ask);
    ask = {};
    asio::post(server.loop, [self = std::move(self), answer = std::move(answer)]() mutable {
      if (self->stage_ == Stage::answering) self->answered(std::move(answer));
    });
  });
}

void Connection::answered(Answer answer) {
  const Passed& passed = intake_.passed();
  respond({.answer = unless_known(std::move(answer), passed.if_none_match),
           .is_head = passed.is_head,
           .keeps_open = intake_.keeps_open()});
}

void Connection::refuse(const Refusal& refusal) {
  respond({.answer = answer_of(refusal)});
}

// ---------------------------------------------------------------------------------------- writing

void Connection::respond(Reply reply) {
  set_stage(Stage::writing);
  reply_ = std::move(reply);
  head_ = head_text(reply_);
  content_ = content_of(reply_);
  head_written_ = 0;
  content_written_ = 0;
  counted_bytes_ = content_.size();
  server_.answers_bytes += counted_bytes_;
  server_.bound_answers();
  if (stage_ == Stage::writing) write_piece();
}

void Connection::write_piece() {
  const std::size_t head_left = head_.size() - head_written_;
  const std::size_t piece = std::min(content_.size() - content_written_, k_piece_bytes);
  const std::array<asio::const_buffer, 2> buffers{
      asio::buffer(head_.data() + head_written_, head_left),
      asio::buffer(content_.data() + content_written_, piece)};
  set_deadline(server_.options.limits.write_s_max);
  asio::async_write(socket_, buffers,
                    [self = shared_from_this(), piece](const Error& error, std::size_t) {
                      if (self->stage_ != Stage::writing) return;
                      if (error) return self->close();
                      self->head_written_ = self->head_.size();
                      self->content_written_ += piece;
                      if (self->content_written_ < self->content_.size())
                        return self->write_piece();
                      self->wrote();
                    });
}

void Connection::wrote() {
  const bool keeps_open = reply_.keeps_open;
  release_answer();
  if (!keeps_open) return linger();
  intake_.next();
  is_head_begun_ = false;
  is_body_begun_ = false;
  set_stage(Stage::reading);
  set_deadline(server_.options.limits.head_s_max);
  advance();
}

void Connection::release_answer() {
  server_.answers_bytes -= std::exchange(counted_bytes_, 0);
  content_ = {};
  head_ = {};
  reply_ = {};
}

void Connection::linger() {
  set_stage(Stage::lingering);
  Error error;
  socket_.shutdown(asio::ip::tcp::socket::shutdown_send, error);
  if (error) return close();
  set_deadline(server_.options.limits.linger_s_max);
  read_and_drop();
}

void Connection::read_and_drop() {
  socket_.async_read_some(asio::buffer(dropped_),
                          [self = shared_from_this()](const Error& error, std::size_t) {
                            if (self->stage_ != Stage::lingering) return;
                            if (error) return self->close();
                            self->read_and_drop();
                          });
}

// -------------------------------------------------------------------------------------- streaming

void Connection::stream() {
  CHECK(stage_ == Stage::answering);
  set_stage(Stage::streaming);
  push(std::make_shared<const std::string>(stream_head_text()));
  for (const auto& [name, text] : server_.newest_events)
    push(text);
  if (stage_ == Stage::streaming) watch_for_end();
}

void Connection::push(const std::shared_ptr<const std::string>& text) {
  if (stage_ != Stage::streaming) return;
  // A single event may exceed the limit: the program itself wrote it, and all streams share it.
  if (!events_.empty() && events_bytes_ + text->size() > server_.options.limits.stream_bytes_max)
    return close_as_too_much();
  events_.push_back(text);
  events_bytes_ += text->size();
  if (!is_event_written_) write_event();
}

void Connection::write_event() {
  is_event_written_ = true;
  set_deadline(server_.options.limits.write_s_max);
  // The lambda keeps the text alive during the write, because closing a stream drops its events.
  asio::async_write(
      socket_, asio::buffer(*events_.front()),
      [self = shared_from_this(), text = events_.front()](const Error& error, std::size_t) {
        if (self->stage_ != Stage::streaming) return;
        if (error) return self->close();
        self->events_bytes_ -= text->size();
        self->events_.pop_front();
        self->is_event_written_ = false;
        ++self->deadline_number_;
        if (!self->events_.empty()) self->write_event();
      });
}

/// A stream's reader sends nothing more, so the read ends only when the reader disconnects.
void Connection::watch_for_end() {
  socket_.async_read_some(asio::buffer(dropped_),
                          [self = shared_from_this()](const Error&, std::size_t) {
                            if (self->stage_ == Stage::streaming) self->close();
                          });
}

}  // namespace sleight::web
