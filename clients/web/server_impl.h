// State shared by a server and its connections.
//
// Thread safety: only the loop's thread uses this state, except where noted.
#pragma once

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "clients/web/guard.h"
#include "clients/web/intake.h"
#include "clients/web/keys.h"
#include "clients/web/server.h"
#include "common/base/descriptor.h"

namespace sleight::web {

class Connection;

struct Server::Impl {
  Impl(ServerOptions wanted, Handler answering);
  ~Impl();
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  /// Accepts a listening socket's connections.
  struct Listener {
    Listener(Impl& owner, base::Descriptor descriptor);
    boost::asio::ip::tcp::acceptor acceptor;
    boost::asio::steady_timer again;
    bool fails = false;  ///< so that failures in a row are reported once
  };
  void listen();
  void accept_when_ready(Listener& from);
  void accept(Listener& from);
  void admit(boost::asio::ip::tcp::socket socket);
  bool make_room();
  void comment_streams();
  void publish(const std::string& event, std::shared_ptr<const std::string> text);
  void stop();

  /// If the answers being sent use too much memory, closes connections. Those that have been
  /// receiving longest are closed first.
  void bound_answers();
  void start_stream(const std::shared_ptr<Connection>& connection);
  void forget(const std::shared_ptr<Connection>& connection);

  /// Returns the handler's answer, or an error if the handler throws. Runs on any thread.
  Answer answer(const Ask& ask) const;
  /// On any thread.
  void complain(const std::string& words) const;

  ServerOptions options;
  Handler handler;
  std::uint16_t port = 0;
  Keys keys;
  BodyBudget bodies;

  std::atomic<std::size_t> connection_count = 0;  ///< this and the next five: read by any thread
  std::atomic<std::size_t> stream_count = 0;
  std::atomic<std::size_t> answers_bytes = 0;
  std::atomic<std::uint64_t> accepted = 0;
  std::atomic<std::uint64_t> closed = 0;
  std::atomic<std::uint64_t> asks = 0;

  mutable std::mutex link_mutex;
  std::string newest_token;

  std::unique_ptr<Guard> guard;
  std::map<std::string, std::shared_ptr<const std::string>> newest_events;

  boost::asio::io_context loop{1};
  std::unique_ptr<Listener> listener;
  boost::asio::steady_timer comments{loop};
  /// Connections by number, in the order of their arrival.
  std::map<std::uint64_t, std::shared_ptr<Connection>> connections;
  std::map<std::uint64_t, std::shared_ptr<Connection>> streams;

  std::mutex stop_mutex;
  bool is_stopped = false;
  /// The pool is declared last but one, so that it is destroyed before the members above, which its
  /// threads use.
  std::unique_ptr<boost::asio::thread_pool> pool;
  std::thread loop_thread;
};

}  // namespace sleight::web
