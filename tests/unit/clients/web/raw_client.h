// A client on a plain blocking socket that sends any bytes and reads the answers.
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "clients/web/server.h"
#include "common/base/descriptor.h"

namespace sleight::web::testing {

/// If a server doesn't answer within this time, the test fails.
inline constexpr int k_wait_s = 60;

struct Received {
  int status = 0;  ///< 0: no answer
  std::string head{};
  std::string content{};

  std::string field(const std::string& name) const {
    const std::size_t at = head.find("\r\n" + name + ": ");
    if (at == std::string::npos) return "";
    const std::size_t begin = at + name.size() + 4;
    return head.substr(begin, head.find("\r\n", begin) - begin);
  }
};

class RawClient {
 public:
  /// If `receive_buffer` is above 0, it limits the number of unread bytes, as far as the system
  /// allows.
  explicit RawClient(std::uint16_t port, int receive_buffer = 0)
      : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    const timeval wait{.tv_sec = k_wait_s, .tv_usec = 0};
    ::setsockopt(socket_.get(), SOL_SOCKET, SO_RCVTIMEO, &wait, sizeof wait);
    ::setsockopt(socket_.get(), SOL_SOCKET, SO_SNDTIMEO, &wait, sizeof wait);
    if (receive_buffer > 0)
      ::setsockopt(socket_.get(), SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    is_connected_ =
        ::connect(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }

  bool is_connected() const { return is_connected_; }
  int descriptor() const { return socket_.get(); }

  bool send(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t count = ::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(count));
    }
    return true;
  }
  void end_sending() { ::shutdown(socket_.get(), SHUT_WR); }

  /// Returns the next answer; an answer to HEAD has no content.
  Received receive(bool is_head = false) {
    Received received;
    while (buffer_.find("\r\n\r\n") == std::string::npos)
      if (!read_more()) return received;
    const std::size_t end = buffer_.find("\r\n\r\n") + 4;
    received.head = buffer_.substr(0, end);
    buffer_.erase(0, end);
    if (received.head.starts_with("HTTP/1.1 "))
      received.status = std::atoi(received.head.c_str() + 9);
    const std::string length = received.field("Content-Length");
    if (length.empty() || is_head) return received;
    const std::size_t size = std::strtoull(length.c_str(), nullptr, 10);
    while (buffer_.size() < size)
      if (!read_more()) return received;
    received.content = buffer_.substr(0, size);
    buffer_.erase(0, size);
    return received;
  }
  Received ask(std::string_view bytes, bool is_head = false) {
    send(bytes);
    return receive(is_head);
  }
  /// Returns the stream's bytes up to and including `text`, or all bytes if `text` doesn't occur.
  std::string receive_until(std::string_view text) {
    while (buffer_.find(text) == std::string::npos)
      if (!read_more()) return std::exchange(buffer_, {});
    const std::size_t end = buffer_.find(text) + text.size();
    std::string received = buffer_.substr(0, end);
    buffer_.erase(0, end);
    return received;
  }
  /// Waits until the other end closes the connection. Returns false after a timeout, or if more
  /// than `bytes_max` bytes arrive.
  bool is_closed(std::size_t bytes_max = 0) {
    while (buffer_.size() <= bytes_max)
      if (!read_more()) return !has_waited_in_vain_;
    return false;
  }

 private:
  bool read_more() {
    char bytes[16384];
    ssize_t count = 0;
    do {
      count = ::recv(socket_.get(), bytes, sizeof bytes, 0);
    } while (count < 0 && errno == EINTR);
    has_waited_in_vain_ = count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK);
    if (count <= 0) return false;
    buffer_.append(bytes, static_cast<std::size_t>(count));
    return true;
  }

  base::Descriptor socket_;
  bool is_connected_ = false;
  bool has_waited_in_vain_ = false;
  std::string buffer_;
};

class Browser {
 public:
  explicit Browser(Server& server) : port_(server.port()) {
    const std::string link = server.new_link();
    const Received received =
        RawClient(port_).ask(request("GET", link.substr(link.find("/?")), ""));
    EXPECT_EQ(received.status, 303) << received.head;
    const std::string cookie = received.field("Set-Cookie");
    cookie_ = cookie.substr(0, cookie.find(';'));
  }

  std::string host() const { return "127.0.0.1:" + std::to_string(port_); }
  const std::string& cookie() const { return cookie_; }
  std::string request(const std::string& method, const std::string& target, const std::string& more,
                      const std::string& body = "") const {
    return method + " " + target + " HTTP/1.1\r\nHost: " + host() + "\r\n" +
           (cookie_.empty() ? "" : "Cookie: " + cookie_ + "\r\n") + more + "\r\n" + body;
  }
  std::string get(const std::string& target, const std::string& more = "") const {
    return request("GET", target, more);
  }
  std::string post_head(const std::string& target, std::size_t size,
                        const std::string& more = "") const {
    return request("POST", target,
                   "Origin: http://" + host() + "\r\nContent-Type: application/json\r\n" +
                       "Content-Length: " + std::to_string(size) + "\r\n" + more);
  }
  std::string post(const std::string& target, const std::string& body) const {
    return post_head(target, body.size()) + body;
  }
  std::string stream() const { return get("/api/events", "Sec-Fetch-Site: same-origin\r\n"); }

 private:
  std::uint16_t port_;
  std::string cookie_;
};

}  // namespace sleight::web::testing
