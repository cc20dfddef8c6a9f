#include "common/access/certificates.h"

#include <fmt/format.h>
#include <netdb.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>
#include <sys/socket.h>
#include <sys/time.h>

#include <array>
#include <cmath>
#include <cstring>
#include <memory>

#include "common/base/descriptor.h"
#include "common/base/error.h"

namespace sleight::access {
namespace {

constexpr long k_valid_s = 3650L * 86400;
constexpr long k_clocks_differ_s = 86400;  // a client's clock may be behind this machine's

struct Freer {
  void operator()(X509* it) const { ::X509_free(it); }
  void operator()(EVP_PKEY* it) const { ::EVP_PKEY_free(it); }
  void operator()(BIO* it) const { ::BIO_free(it); }
  void operator()(SSL_CTX* it) const { ::SSL_CTX_free(it); }
  void operator()(SSL* it) const { ::SSL_free(it); }
  void operator()(X509_EXTENSION* it) const { ::X509_EXTENSION_free(it); }
  void operator()(addrinfo* it) const { ::freeaddrinfo(it); }
  void operator()(GENERAL_NAMES* it) const { ::GENERAL_NAMES_free(it); }
};
template <class T>
using Held = std::unique_ptr<T, Freer>;

std::string reason() {
  const unsigned long code = ::ERR_get_error();
  ::ERR_clear_error();
  const char* words = code == 0 ? nullptr : ::ERR_reason_error_string(code);
  return words == nullptr ? "unknown reason" : words;
}

void need(bool is_good, const char* what) {
  if (!is_good) throw base::Error(fmt::format("{}: {}", what, reason()));
}

Held<BIO> reader_of(std::string_view text) {
  return Held<BIO>(::BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

std::string text_in(BIO* bio) {
  char* begin = nullptr;
  const long size = BIO_get_mem_data(bio, &begin);
  return {begin, static_cast<std::size_t>(size)};
}

std::string text_of(const ASN1_STRING* text) {
  return {reinterpret_cast<const char*>(::ASN1_STRING_get0_data(text)),
          static_cast<std::size_t>(::ASN1_STRING_length(text))};
}

std::string pem_of(X509* certificate) {
  const Held<BIO> text(::BIO_new(::BIO_s_mem()));
  need(text != nullptr && ::PEM_write_bio_X509(text.get(), certificate) == 1,
       "can't write a certificate");
  return text_in(text.get());
}

Held<X509> first_certificate(std::string_view text) {
  Held<X509> certificate(::PEM_read_bio_X509(reader_of(text).get(), nullptr, nullptr, nullptr));
  need(certificate != nullptr, "expected a certificate in PEM");
  return certificate;
}

/// Prevents OpenSSL from prompting for a key's passphrase.
int no_passphrase(char*, int, int, void*) {
  return 0;
}

void add_extension(X509* certificate, int kind, const char* value) {
  const Held<X509_EXTENSION> extension(::X509V3_EXT_conf_nid(nullptr, nullptr, kind, value));
  need(extension != nullptr && ::X509_add_ext(certificate, extension.get(), -1) == 1,
       "can't create a certificate");
}

base::Descriptor connect_to_host(const ServerAddress& address, double seconds_max) {
  addrinfo hints = {};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const std::string port = std::to_string(address.port);
  const int failure = ::getaddrinfo(address.host.c_str(), port.c_str(), &hints, &found);
  if (failure != 0)
    throw base::Error(
        fmt::format("can't find the host {}: {}", address.host, ::gai_strerror(failure)));
  const Held<addrinfo> held(found);
  int error = ECONNREFUSED;
  for (const addrinfo* one = found; one != nullptr; one = one->ai_next) {
    base::Descriptor socket(
        ::socket(one->ai_family, one->ai_socktype | SOCK_CLOEXEC, one->ai_protocol));
    if (!socket) continue;
    timeval patience = {};
    patience.tv_sec = static_cast<time_t>(std::ceil(seconds_max));
    ::setsockopt(socket.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    ::setsockopt(socket.get(), SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    if (::connect(socket.get(), one->ai_addr, one->ai_addrlen) == 0) return socket;
    error = errno;
  }
  throw base::Error(base::ExitCode::no_server,
                    fmt::format("no server answers at {}: {}", access::text_of(address),
                                std::strerror(error == EINPROGRESS ? ETIMEDOUT : error)));
}

class Handshake {
 public:
  Handshake(const ServerAddress& address, const std::string& name, double seconds_max)
      : address_(address),
        socket_(connect_to_host(address, seconds_max)),
        context_(::SSL_CTX_new(::TLS_client_method())),
        tls_(context_ == nullptr ? nullptr : ::SSL_new(context_.get())) {
    need(tls_ != nullptr && ::SSL_set_fd(tls_.get(), socket_.get()) == 1 &&
             SSL_set_tlsext_host_name(tls_.get(), name.c_str()) == 1,
         "can't set up TLS");
  }

  void trust_anybody() const { ::SSL_set_verify(tls_.get(), SSL_VERIFY_NONE, nullptr); }

  /// Lets the connection fail unless OpenSSL trusts the server's certificate, and the certificate
  /// is for the host `name`. `certificates`: PEM of the trusted authorities; empty: the system's.
  void trust(const std::string& certificates, const std::string& name) const {
    X509_STORE* store = ::SSL_CTX_get_cert_store(context_.get());
    if (certificates.empty())
      need(::X509_STORE_set_default_paths(store) == 1,
           "can't load the system's trusted certificates");
    for (const std::string& one : certificates_in(certificates))
      ::X509_STORE_add_cert(store, first_certificate(one).get());
    ::SSL_set_verify(tls_.get(), SSL_VERIFY_PEER, nullptr);
    need(::SSL_set1_host(tls_.get(), name.c_str()) == 1, "can't set up TLS");
  }

  bool succeeds() const {
    ::ERR_clear_error();
    return ::SSL_connect(tls_.get()) == 1;
  }
  [[noreturn]] void fail() const {
    throw base::Error(fmt::format("the program that answers at {} does not use TLS: {}",
                                  access::text_of(address_), reason()));
  }
  SSL* tls() const { return tls_.get(); }

 private:
  ServerAddress address_;
  base::Descriptor socket_;
  Held<SSL_CTX> context_;
  Held<SSL> tls_;
};

}  // namespace

Keypair make_self_signed() {
  const char* const what = "can't create a certificate";
  const Held<EVP_PKEY> key(::EVP_EC_gen("P-256"));
  need(key != nullptr, what);
  const Held<X509> certificate(::X509_new());
  need(certificate != nullptr, what);
  std::uint64_t serial = 0;
  need(::RAND_bytes(reinterpret_cast<unsigned char*>(&serial), sizeof serial) == 1, what);
  need(::X509_set_version(certificate.get(), X509_VERSION_3) == 1 &&
           ::ASN1_INTEGER_set_uint64(::X509_get_serialNumber(certificate.get()), serial >> 1U) ==
               1 &&
           ::X509_gmtime_adj(X509_getm_notBefore(certificate.get()), -k_clocks_differ_s) !=
               nullptr &&
           ::X509_gmtime_adj(X509_getm_notAfter(certificate.get()), k_valid_s) != nullptr &&
           ::X509_set_pubkey(certificate.get(), key.get()) == 1,
       what);
  X509_NAME* name = ::X509_get_subject_name(certificate.get());
  need(::X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC,
                                    reinterpret_cast<const unsigned char*>(k_self_name), -1, -1,
                                    0) == 1 &&
           ::X509_set_issuer_name(certificate.get(), name) == 1,
       what);
  add_extension(certificate.get(), NID_subject_alt_name,
                fmt::format("DNS:{}", k_self_name).c_str());
  add_extension(certificate.get(), NID_basic_constraints, "critical,CA:TRUE,pathlen:0");
  add_extension(certificate.get(), NID_key_usage, "critical,digitalSignature,keyCertSign");
  add_extension(certificate.get(), NID_ext_key_usage, "serverAuth");
  need(::X509_sign(certificate.get(), key.get(), ::EVP_sha256()) > 0, what);

  const Held<BIO> certificate_text(::BIO_new(::BIO_s_mem()));
  const Held<BIO> key_text(::BIO_new(::BIO_s_mem()));
  need(::PEM_write_bio_X509(certificate_text.get(), certificate.get()) == 1 &&
           ::PEM_write_bio_PrivateKey(key_text.get(), key.get(), nullptr, nullptr, 0, nullptr,
                                      nullptr) == 1,
       what);
  return {.certificate = text_in(certificate_text.get()), .key = text_in(key_text.get())};
}

std::string fingerprint_of(std::string_view certificate) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  const Held<X509> first = first_certificate(certificate);
  need(::X509_digest(first.get(), ::EVP_sha256(), digest.data(), &size) == 1,
       "can't compute the fingerprint of a certificate");
  std::string text = "SHA256:";
  for (unsigned i = 0; i < size; ++i)
    text += fmt::format("{:02x}", digest[i]);
  return text;
}

std::optional<std::string> self_signed_name(std::string_view certificate) {
  const Held<X509> first = first_certificate(certificate);
  if (::X509_self_signed(first.get(), 1) != 1) return std::nullopt;
  const Held<GENERAL_NAMES> names(static_cast<GENERAL_NAMES*>(
      ::X509_get_ext_d2i(first.get(), NID_subject_alt_name, nullptr, nullptr)));
  for (int i = 0; names && i < sk_GENERAL_NAME_num(names.get()); ++i) {
    const GENERAL_NAME* name = sk_GENERAL_NAME_value(names.get(), i);
    if (name->type == GEN_DNS) return text_of(name->d.dNSName);
  }
  // If the certificate has no alternative names, use the common name.
  const X509_NAME* subject = ::X509_get_subject_name(first.get());
  const int at = ::X509_NAME_get_index_by_NID(subject, NID_commonName, -1);
  if (names || at < 0) return std::nullopt;
  return text_of(::X509_NAME_ENTRY_get_data(::X509_NAME_get_entry(subject, at)));
}

std::vector<std::string> certificates_in(std::string_view text) {
  const Held<BIO> reader = reader_of(text);
  std::vector<std::string> found;
  while (const Held<X509> one{::PEM_read_bio_X509(reader.get(), nullptr, nullptr, nullptr)})
    found.push_back(pem_of(one.get()));
  ::ERR_clear_error();  // no more certificates
  return found;
}

bool is_valid_now(std::string_view certificate) {
  const Held<X509> first = first_certificate(certificate);
  return ::X509_cmp_current_time(X509_get0_notBefore(first.get())) < 0 &&
         ::X509_cmp_current_time(X509_get0_notAfter(first.get())) > 0;
}

void check_keypair(const Keypair& keypair) {
  const Held<X509> certificate = first_certificate(keypair.certificate);
  const Held<EVP_PKEY> key(
      ::PEM_read_bio_PrivateKey(reader_of(keypair.key).get(), nullptr, &no_passphrase, nullptr));
  need(key != nullptr, "can't read the key; expected PEM without a passphrase");
  if (::X509_check_private_key(certificate.get(), key.get()) != 1) {
    ::ERR_clear_error();
    throw base::Error("the key does not match the certificate");
  }
}

std::string certificate_shown_at(const ServerAddress& address, double seconds_max) {
  const Handshake handshake(address, address.host, seconds_max);
  handshake.trust_anybody();
  if (!handshake.succeeds()) handshake.fail();
  const Held<X509> shown(::SSL_get1_peer_certificate(handshake.tls()));
  if (shown == nullptr) throw base::Error("the server sent no certificate");
  return pem_of(shown.get());
}

std::string fault_of_certificate_at(const ServerAddress& address, const std::string& name,
                                    const std::string& trusted, double seconds_max) {
  const Handshake handshake(address, name, seconds_max);
  handshake.trust(trusted, name);
  if (handshake.succeeds()) return {};
  const long fault = ::SSL_get_verify_result(handshake.tls());
  if (fault == X509_V_OK) handshake.fail();
  return ::X509_verify_cert_error_string(fault);
}

}  // namespace sleight::access
