// Connections that can send any bytes: over a Unix socket, TCP, or TLS (also encrypted bytes).
//
// Each wait has a timeout. The result tells whether the wait timed out.
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

/// Maximum time in which the server must answer, or close a connection that its peer has ended.
inline constexpr int k_patience_ms = 10'000;

enum class Got : std::uint8_t {
  bytes,
  nothing,  ///< timeout
  ended,    ///< by the server
};

class Line {
 public:
  virtual ~Line() = default;
  Line() = default;
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;

  /// Sends all bytes, and stores data that arrives meanwhile for receive(). Returns false if the
  /// server has closed the connection, or accepts nothing for k_patience_ms.
  virtual bool send(std::string_view bytes) = 0;
  /// Like send(), without reading. Returns false also if the server accepts nothing for
  /// `patience_ms`.
  virtual bool send_unread(std::string_view bytes, int patience_ms) = 0;
  /// Appends received bytes to `into`.
  virtual Got receive(std::string& into, int patience_ms) = 0;
  virtual void end_sending() = 0;
};

/// Returns null if the server refuses the connection.
std::unique_ptr<Line> line_to_socket(const std::string& path);
/// Connects from the address in 127.0.0.0/8 that `number` chooses, because one address has ports
/// for only some hundred connections per second. REQUIRES: `address.host` is 127.0.0.1.
std::unique_ptr<Line> line_to_port(const access::ServerAddress& address, std::uint64_t number);

/// Settings for all TLS connections. Several threads may use one object at once.
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

/// One end of a TLS connection without a socket. The caller transports the encrypted bytes.
class Tls {
 public:
  explicit Tls(const TlsSettings& settings);

  Shake shake();
  void give(std::string_view encrypted);
  /// Returns the bytes to send.
  std::string take();
  std::string encrypt(std::string_view bytes);
  /// Appends decrypted bytes. Returns false if the peer ended or broke the connection.
  bool decrypt(std::string& into);
  SSL* ssl() { return ssl_.get(); }

 private:
  struct Free {
    void operator()(SSL* ssl) const { SSL_free(ssl); }
  };
  std::unique_ptr<SSL, Free> ssl_;
};

/// Does the handshake over `line`. Returns false if the server closed the connection.
bool shake_hands(Line& line, Tls& tls);

/// Does the handshake and returns a TLS line over `line`. Returns null if the server closed the
/// connection.
std::unique_ptr<Line> secured(std::unique_ptr<Line> line, const TlsSettings& settings);

}  // namespace sleight::attack
