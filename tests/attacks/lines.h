// Connections to a server on which anything can be sent: its Unix socket, plain TCP, and TLS of
// which the encrypted bytes are at hand.
//
// A line never waits without an end: each wait has its patience, after which it says so.
//
// Thread safety: a line belongs to one thread.
#pragma once

#include <openssl/ssl.h>

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "common/access/server_address.h"

namespace sleight::attack {

/// The server has `patience` for what is its duty: an answer, the end of a connection that its
/// peer has ended.
inline constexpr int k_patience_ms = 10'000;

enum class Got : std::uint8_t {
  bytes,
  nothing,  ///< in the time that was given
  ended,    ///< by the server
};

class Line {
 public:
  virtual ~Line() = default;
  Line() = default;
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;

  /// All of it; what comes meanwhile is kept for `receive`. False where the server has ended the
  /// line, or takes nothing for k_patience_ms.
  virtual bool send(std::string_view bytes) = 0;
  /// As a peer that reads nothing; false also where the server takes no more for `patience_ms`.
  virtual bool send_unread(std::string_view bytes, int patience_ms) = 0;
  /// Appends to `into`.
  virtual Got receive(std::string& into, int patience_ms) = 0;
  /// Nothing more will be sent.
  virtual void end_sending() = 0;
};

/// Null where the server takes no connection.
std::unique_ptr<Line> line_to_socket(const std::string& path);
/// From an address of 127.0.0.0/8 that `number` chooses: one address has ports for some hundred
/// connections a second alone. `address.host` must be 127.0.0.1.
std::unique_ptr<Line> line_to_port(const access::ServerAddress& address, std::uint64_t number);

/// What ends of TLS have in common. May be used by several threads at once.
class TlsSettings {
 public:
  /// `version_max`: TLS1_2_VERSION or TLS1_3_VERSION.
  explicit TlsSettings(int version_max);
  SSL_CTX* context() const { return context_.get(); }

 private:
  struct Free {
    void operator()(SSL_CTX* context) const { SSL_CTX_free(context); }
  };
  std::unique_ptr<SSL_CTX, Free> context_;
};

enum class Shake : std::uint8_t { done, goes_on, broken };

/// One end of TLS, without a socket: encrypted bytes go in and come out.
class Tls {
 public:
  explicit Tls(const TlsSettings& settings);

  Shake shake();
  void give(std::string_view encrypted);
  /// What is to be sent.
  std::string take();
  std::string encrypt(std::string_view bytes);
  /// Appends what can be read. False: the other side has ended it, or broke it.
  bool decrypt(std::string& into);
  SSL* ssl() { return ssl_.get(); }

 private:
  struct Free {
    void operator()(SSL* ssl) const { SSL_free(ssl); }
  };
  std::unique_ptr<SSL, Free> ssl_;
};

/// Shakes hands over `line`. False where the server ended it.
bool shake_hands(Line& line, Tls& tls);

/// A line within TLS, the handshake done; null where the server ended it.
std::unique_ptr<Line> secured(std::unique_ptr<Line> line, const TlsSettings& settings);

}  // namespace sleight::attack
