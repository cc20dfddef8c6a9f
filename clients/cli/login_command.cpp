#include "clients/cli/login_command.h"

#include <fmt/format.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdio>

#include "clients/cli/service_json.h"
#include "clients/service_client/known_servers.h"
#include "clients/service_client/service_call.h"
#include "clients/terminal/output.h"
#include "clients/terminal/terminal.h"
#include "common/access/certificates.h"
#include "common/access/token_text.h"
#include "common/base/error.h"
#include "common/base/file_system.h"

namespace sleight::cli {
namespace {

constexpr double k_login_s_max = 20;
constexpr std::size_t k_pem_bytes_max = std::size_t{1} << 20U;
constexpr std::size_t k_token_file_bytes_max = 4096;

access::ServerAddress address_of(const std::string& text) {
  const auto address = access::server_address_of(text);
  if (!address || address->port == 0) {
    terminal::refuse_usage(fmt::format("{}: expected an address such as render.example.org:{}",
                                       terminal::shown(text), access::k_port));
  }
  return *address;
}

/// While this object exists, the terminal hides typed text.
class WithoutEcho {
 public:
  WithoutEcho() {
    if (::tcgetattr(STDIN_FILENO, &before_) != 0) return;
    termios silent = before_;
    silent.c_lflag &= ~static_cast<tcflag_t>(ECHO);
    is_set_ = ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &silent) == 0;
  }
  ~WithoutEcho() {
    if (!is_set_) return;
    ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &before_);
    std::fputs("\n", stderr);
  }
  WithoutEcho(const WithoutEcho&) = delete;
  WithoutEcho& operator=(const WithoutEcho&) = delete;

 private:
  termios before_{};
  bool is_set_ = false;
};

std::string line_of_stdin() {
  std::string line;
  for (int c = std::getchar(); c != EOF && c != '\n' && line.size() < k_token_file_bytes_max;
       c = std::getchar())
    line += static_cast<char>(c);
  return line;
}

std::string token_given(const LoginOptions& options) {
  std::string text;
  if (!options.token_file.empty()) {
    text = base::read_text_file(options.token_file, k_token_file_bytes_max);
  } else if (terminal::is_typed()) {
    std::fputs("Token: ", stderr);
    const WithoutEcho hidden;
    text = line_of_stdin();
  } else {
    text = line_of_stdin();
  }
  std::erase_if(text, [](unsigned char c) { return std::isspace(c) != 0; });
  if (!access::token_of(text)) {
    // Don't print the text, because it may be a valid token with a small mistake.
    terminal::refuse_usage(
        "invalid token: a token begins with sleight_ and ends with a checksum; copy the whole "
        "token");
  }
  return text;
}

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// Returns the 64 digits of a fingerprint. The text may have upper case, colons, and a prefix
/// before the digits.
std::string digits_of_fingerprint(const std::string& text) {
  std::string digits = lower(text);
  const std::size_t before = digits.find_last_of("=");
  if (before != std::string::npos) digits.erase(0, before + 1);
  if (digits.starts_with("sha256:")) digits.erase(0, 7);
  std::erase(digits, ':');
  if (digits.size() == 64 && digits.find_first_not_of("0123456789abcdef") == std::string::npos)
    return digits;
  terminal::refuse_usage(
      "--fingerprint: expected SHA256: and 64 hexadecimal digits, as printed by `sleight server "
      "status` on the service's machine");
}

/// Sets how to verify a service's certificate if no certificate authority of the system has signed
/// it.
void set_trust(const LoginOptions& options, rpc::RemoteService& service) {
  if (!options.ca_file.empty()) {
    service.certificate = base::read_text_file(options.ca_file, k_pem_bytes_max);
    if (access::certificates_in(service.certificate).empty())
      terminal::refuse_usage(fmt::format("{}: contains no certificate in PEM format",
                                         terminal::shown(options.ca_file)));
    return;
  }
  if (options.fingerprint.empty()) return;
  const std::string wanted = digits_of_fingerprint(options.fingerprint);
  const std::string pem = access::certificate_shown_at(service.address, k_login_s_max);
  const std::string seen = access::fingerprint_of(pem);
  if (digits_of_fingerprint(seen) != wanted) {
    throw base::Error(
        base::ExitCode::not_allowed,
        fmt::format(
            "{} presented the certificate {}, which does not match --fingerprint: either the "
            "server has a new certificate, or someone is intercepting the connection. To see "
            "the right fingerprint, run `sleight server status` on the server's machine",
            access::text_of(service.address), seen));
  }
  const auto own_name = access::self_signed_name(pem);
  if (!own_name) {
    terminal::refuse_usage(fmt::format(
        "the certificate of {} is signed by an authority: instead of --fingerprint, use --ca FILE "
        "with the authority's certificate; if the system trusts the authority, use neither",
        access::text_of(service.address)));
  }
  service.certificate = pem;
  service.own_name = *own_name;
}

}  // namespace

int login(const LoginOptions& options) {
  const access::ServerAddress address = address_of(options.address);
  rpc::RemoteService service{.address = address, .token = token_given(options)};
  set_trust(options, service);
  rpc::Client client(service, {.call_s_max = k_login_s_max});
  try {
    client.enter();
  } catch (const rpc::NotTrusted& error) {
    if (!service.certificate.empty()) throw;
    const std::string pem = access::certificate_shown_at(address, k_login_s_max);
    const std::string name = access::text_of(address);
    if (!access::self_signed_name(pem)) {
      throw base::Error(base::ExitCode::not_allowed,
                        fmt::format("{}; to trust another authority, add --ca FILE", error.what()));
    }
    throw base::Error(base::ExitCode::not_allowed,
                      fmt::format("{0}\n"
                                  "The server's certificate has the fingerprint\n"
                                  "  {2}.\n"
                                  "Compare this fingerprint with the output of `sleight server "
                                  "status` on the server's machine. If both are the same, run\n"
                                  "  sleight login {1} --fingerprint {2}",
                                  error.what(), name, access::fingerprint_of(pem)));
  } catch (const rpc::NoServer& error) {
    throw base::Error(base::ExitCode::no_server, terminal::shown(error.what()));
  } catch (const rpc::RefusedError& error) {
    throw base::Error(service_client::exit_code_of(error.refusal().kind),
                      service_client::words_of(error.refusal()));
  }
  const std::string path = service_client::remember(service);
  const std::string name = access::text_of(address);
  if (options.json) {
    fmt::print("{}\n", indented({{"server", name}, {"file", path}}));
  } else {
    fmt::print(
        "logged in to {0}. To send commands to this server, run\n"
        "  export SLEIGHT_SERVER={0}\n",
        name);
  }
  return static_cast<int>(base::ExitCode::ok);
}

int logout(const std::string& text, bool json) {
  const access::ServerAddress address = address_of(text);
  const bool was_known = service_client::forget(address);
  if (json) {
    fmt::print("{}\n", indented({{"server", access::text_of(address)}, {"was_known", was_known}}));
  } else {
    fmt::print("{}\n",
               was_known
                   ? "deleted the stored token; the token itself remains valid until it is revoked"
                   : "there was no stored login for this server");
  }
  return static_cast<int>(base::ExitCode::ok);
}

}  // namespace sleight::cli
