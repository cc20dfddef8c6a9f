#include "tests/attacks/lines.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <openssl/err.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "common/base/check.h"
#include "common/base/descriptor.h"
#include "common/rpc/unix_socket.h"

namespace sleight::attack {
namespace {

class PlainLine final : public Line {
 public:
  explicit PlainLine(base::Descriptor descriptor) : descriptor_(std::move(descriptor)) {
    ::fcntl(descriptor_.get(), F_SETFL, ::fcntl(descriptor_.get(), F_GETFL) | O_NONBLOCK);
  }
  bool send(std::string_view bytes) override {
    while (!bytes.empty()) {
      pollfd looked = {.fd = descriptor_.get(), .events = POLLIN | POLLOUT, .revents = 0};
      if (has_ended_) looked.events = POLLOUT;
      if (::poll(&looked, 1, k_patience_ms) <= 0) return false;
      if ((looked.revents & POLLIN) != 0) read_some(kept_);
      const auto sent = ::send(descriptor_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent < 0 && errno != EAGAIN) return false;
      if (sent > 0) bytes.remove_prefix(static_cast<std::size_t>(sent));
    }
    return true;
  }
  bool send_unread(std::string_view bytes, int patience_ms) override {
    while (!bytes.empty()) {
      pollfd looked = {.fd = descriptor_.get(), .events = POLLOUT, .revents = 0};
      if (::poll(&looked, 1, patience_ms) <= 0) return false;
      const auto sent = ::send(descriptor_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent < 0 && errno != EAGAIN) return false;
      if (sent > 0) bytes.remove_prefix(static_cast<std::size_t>(sent));
    }
    return true;
  }
  Got receive(std::string& into, int patience_ms) override {
    if (!kept_.empty()) {
      into += std::exchange(kept_, {});
      return Got::bytes;
    }
    if (has_ended_) return Got::ended;
    pollfd looked = {.fd = descriptor_.get(), .events = POLLIN, .revents = 0};
    if (::poll(&looked, 1, patience_ms) <= 0) return Got::nothing;
    if (read_some(into)) return Got::bytes;
    return has_ended_ ? Got::ended : Got::nothing;
  }
  void end_sending() override { ::shutdown(descriptor_.get(), SHUT_WR); }

 private:
  bool read_some(std::string& into) {
    char buffer[16384];
    const auto got = ::read(descriptor_.get(), buffer, sizeof buffer);
    if (got > 0) into.append(buffer, static_cast<std::size_t>(got));
    if (got == 0 || (got < 0 && errno != EAGAIN)) has_ended_ = true;
    return got > 0;
  }

  base::Descriptor descriptor_;
  std::string kept_{};
  bool has_ended_ = false;
};

class SecuredLine final : public Line {
 public:
  SecuredLine(std::unique_ptr<Line> line, std::unique_ptr<Tls> tls)
      : line_(std::move(line)), tls_(std::move(tls)) {}
  bool send(std::string_view bytes) override { return line_->send(tls_->encrypt(bytes)); }
  bool send_unread(std::string_view bytes, int patience_ms) override {
    return line_->send_unread(tls_->encrypt(bytes), patience_ms);
  }
  Got receive(std::string& into, int patience_ms) override {
    const std::size_t before = into.size();
    std::string encrypted;
    // First read data that arrived together with the handshake.
    bool is_open = tls_->decrypt(into);
    while (is_open && into.size() == before) {
      const Got got = line_->receive(encrypted, patience_ms);
      if (got != Got::bytes) return got;
      tls_->give(std::exchange(encrypted, {}));
      is_open = tls_->decrypt(into);
    }
    return into.size() > before ? Got::bytes : Got::ended;
  }
  void end_sending() override { line_->end_sending(); }

 private:
  std::unique_ptr<Line> line_;
  std::unique_ptr<Tls> tls_;
};

}  // namespace

std::unique_ptr<Line> line_to_socket(const std::string& path) {
  const auto descriptor = rpc::connect_to(path);
  if (!descriptor) return nullptr;
  return std::make_unique<PlainLine>(base::Descriptor(descriptor.value()));
}

std::unique_ptr<Line> line_to_port(const access::ServerAddress& address, std::uint64_t number) {
  CHECK(address.host == "127.0.0.1");
  base::Descriptor made(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (!made) return nullptr;
  const int on = 1;
  ::setsockopt(made.get(), IPPROTO_IP, IP_BIND_ADDRESS_NO_PORT, &on, sizeof on);
  ::setsockopt(made.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  sockaddr_in own = {};
  own.sin_family = AF_INET;
  own.sin_addr.s_addr = htonl(INADDR_LOOPBACK + static_cast<std::uint32_t>(number % 60'000));
  sockaddr_in to = own;
  to.sin_port = htons(address.port);
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::bind(made.get(), reinterpret_cast<const sockaddr*>(&own), sizeof own) != 0 ||
      ::connect(made.get(), reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0)
    return nullptr;
  return std::make_unique<PlainLine>(std::move(made));
}

// --------------------------------------------------------------------------------------------- TLS

TlsSettings::TlsSettings(int version_max) : context_(SSL_CTX_new(TLS_client_method())) {
  CHECK(context_ != nullptr);
  // An attacker doesn't verify the server's certificate.
  SSL_CTX_set_verify(context_.get(), SSL_VERIFY_NONE, nullptr);
  CHECK(SSL_CTX_set_max_proto_version(context_.get(), version_max) == 1);
}

Tls::Tls(const TlsSettings& settings) : ssl_(SSL_new(settings.context())) {
  CHECK(ssl_ != nullptr);
  SSL_set_bio(ssl_.get(), BIO_new(BIO_s_mem()), BIO_new(BIO_s_mem()));
  SSL_set_connect_state(ssl_.get());
}

Shake Tls::shake() {
  ERR_clear_error();
  const int result = SSL_do_handshake(ssl_.get());
  if (result == 1) return Shake::done;
  const int why = SSL_get_error(ssl_.get(), result);
  return why == SSL_ERROR_WANT_READ || why == SSL_ERROR_WANT_WRITE ? Shake::goes_on : Shake::broken;
}

void Tls::give(std::string_view encrypted) {
  BIO_write(SSL_get_rbio(ssl_.get()), encrypted.data(), static_cast<int>(encrypted.size()));
}

std::string Tls::take() {
  std::string bytes;
  char buffer[16384];
  for (int got = 0; (got = BIO_read(SSL_get_wbio(ssl_.get()), buffer, sizeof buffer)) > 0;)
    bytes.append(buffer, static_cast<std::size_t>(got));
  return bytes;
}

std::string Tls::encrypt(std::string_view bytes) {
  ERR_clear_error();
  if (!bytes.empty()) SSL_write(ssl_.get(), bytes.data(), static_cast<int>(bytes.size()));
  return take();
}

bool Tls::decrypt(std::string& into) {
  char buffer[16384];
  while (true) {
    ERR_clear_error();
    const int got = SSL_read(ssl_.get(), buffer, sizeof buffer);
    if (got > 0) {
      into.append(buffer, static_cast<std::size_t>(got));
      continue;
    }
    const int why = SSL_get_error(ssl_.get(), got);
    return why == SSL_ERROR_WANT_READ || why == SSL_ERROR_WANT_WRITE;
  }
}

bool shake_hands(Line& line, Tls& tls) {
  std::string encrypted;
  for (Shake how = tls.shake(); how != Shake::done; how = tls.shake()) {
    if (how == Shake::broken || !line.send(tls.take())) return false;
    if (line.receive(encrypted, k_patience_ms) != Got::bytes) return false;
    tls.give(std::exchange(encrypted, {}));
  }
  return line.send(tls.take());
}

std::unique_ptr<Line> secured(std::unique_ptr<Line> line, const TlsSettings& settings) {
  if (!line) return nullptr;
  auto tls = std::make_unique<Tls>(settings);
  if (!shake_hands(*line, *tls)) return nullptr;
  return std::make_unique<SecuredLine>(std::move(line), std::move(tls));
}

}  // namespace sleight::attack
