// One connection of a server: reads requests and writes answers, one after another.
//
// All stages but `answering` have a deadline:
//
//    reading ──▶ answering ──▶ writing ──▶ reading ...
//       │                         └──────▶ lingering ──▶ closed
//       └──▶ streaming ──▶ closed.
//
// In the stage `lingering`, a refused peer may still be sending. If the connection were closed at
// once, the system would reset it, and the peer would lose the answer. So incoming bytes are read
// and dropped for a while.
//
// Thread safety: only the loop's thread calls functions. A handler's thread keeps the connection
// alive and posts to the loop.
#pragma once

#include <array>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>

#include "clients/web/intake.h"
#include "clients/web/reply.h"
#include "clients/web/server_impl.h"

namespace sleight::web {

class Connection : public std::enable_shared_from_this<Connection> {
 public:
  using Moment = std::chrono::steady_clock::time_point;

  /// `is_extra`: the connection exceeds the limit and is refused.
  Connection(Server::Impl& server, boost::asio::ip::tcp::socket socket, std::uint64_t number,
             bool is_extra);

  /// Reads the first request.
  void start();
  /// Sends the refusal and closes. REQUIRES: no answer is being written.
  void refuse(const Refusal& refusal);
  /// Sends the head and the newest events. REQUIRES: the request was for a stream.
  void stream();
  /// REQUIRES: the connection is a stream.
  void push(const std::shared_ptr<const std::string>& text);
  void close();
  /// Closes because of a limit.
  void close_as_too_much();

  std::uint64_t number() const { return number_; }
  bool is_extra() const { return is_extra_; }
  /// Whether the connection may be closed to make room: it has shown no valid cookie yet, or is
  /// lingering.
  bool can_make_room() const;
  bool is_writing() const { return stage_ == Stage::writing; }
  Moment stage_since() const { return stage_since_; }

 private:
  enum class Stage : std::uint8_t { reading, answering, writing, lingering, streaming, closed };

  void set_stage(Stage stage);
  void set_deadline(double seconds);
  void on_deadline();

  void advance();
  void read();
  void proceed();
  void dispatch();
  void ask_handler(Ask ask);
  void answered(Answer answer);
  void respond(Reply reply);
  void write_piece();
  void wrote();
  void linger();
  void read_and_drop();
  void write_event();
  void watch_for_end();
  void release_answer();

  Server::Impl& server_;
  boost::asio::ip::tcp::socket socket_;
  boost::asio::steady_timer deadline_;
  std::uint64_t deadline_number_ = 0;
  std::uint64_t number_;
  Stage stage_ = Stage::reading;
  Moment stage_since_;
  bool is_extra_;
  bool is_known_ = false;       ///< has shown a valid cookie
  bool is_head_begun_ = false;  ///< the deadline for the present request's head is set
  bool is_body_begun_ = false;

  Intake intake_;

  Reply reply_;
  std::string head_;
  base::BytesView content_;
  std::size_t head_written_ = 0;
  std::size_t content_written_ = 0;
  std::size_t counted_bytes_ = 0;

  std::deque<std::shared_ptr<const std::string>> events_;  ///< the first is being written
  std::size_t events_bytes_ = 0;
  bool is_event_written_ = false;

  std::array<char, 4096> dropped_{};
};

}  // namespace sleight::web
