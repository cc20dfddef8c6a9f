// One connection of a server: reads requests, has them answered, writes answers, one after another.
//
// Stages, of which each but `answering` has a deadline:
//
//   reading ──▶ answering ──▶ writing ──▶ reading ...
//      │                         └──────▶ lingering ──▶ closed
//      └──▶ streaming ──▶ closed
//
// Lingering: a refused peer may still be sending. Were the connection closed at once, the system
// would tell it of that in a way that throws away the answer which it has not read yet; so what it
// sends is read and dropped for a while.
//
// Thread safety: the loop's thread alone; a handler's thread keeps it alive and posts to the loop.
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

  /// `is_extra`: one above the limit, to be told so.
  Connection(Server::Impl& server, boost::asio::ip::tcp::socket socket, std::uint64_t number,
             bool is_extra);

  /// Reads its first request.
  void start();
  /// Is told why it is not served, and closed. REQUIRES: nothing is being written.
  void refuse(const Refusal& refusal);
  /// REQUIRES: it asked for a stream. The head, and what is newest.
  void stream();
  /// REQUIRES: it is a stream.
  void push(const std::shared_ptr<const std::string>& text);
  void close();
  /// The same, by a limit.
  void close_as_too_much();

  std::uint64_t number() const { return number_; }
  bool is_extra() const { return is_extra_; }
  /// Whether it may be closed for another one: it has shown no cookie yet, or is done.
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
  bool is_known_ = false;       ///< has shown the cookie
  bool is_head_begun_ = false;  ///< of this request; so far for deadlines
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
