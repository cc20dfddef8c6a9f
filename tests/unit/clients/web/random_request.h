// Random requests and connections. Most requests resemble a browser's requests. Some are hostile or
// damaged.
#pragma once

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "common/random/discrete_distributions.h"
#include "common/random/stream.h"
#include "tests/unit/clients/web/checked_exchange.h"

namespace sleight::web::testing {

inline std::uint64_t below(random::Stream& stream, std::uint64_t bound) {
  return random::UniformInteger{bound}.draw(stream);
}
inline bool one_in(random::Stream& stream, std::uint64_t count) {
  return below(stream, count) == 0;
}
template <std::size_t count>
std::string_view one_of(random::Stream& stream, const std::array<std::string_view, count>& texts) {
  return texts[below(stream, count)];
}

inline std::string random_body(random::Stream& stream) {
  const std::uint64_t size = one_in(stream, 20) ? below(stream, 15'000) : below(stream, 60);
  std::string body;
  for (std::uint64_t i = 0; i < size; ++i) {
    constexpr std::string_view k_signs = "{}\"0123456789\r\n: GETPOST/";
    body += k_signs[below(stream, k_signs.size())];
  }
  return body;
}

inline std::string chunked(const std::string& body, random::Stream& stream) {
  std::string text;
  std::size_t at = 0;
  while (at < body.size()) {
    const std::size_t size = std::min<std::size_t>(1 + below(stream, 40), body.size() - at);
    text += fmt::format("{:x}{}\r\n{}\r\n", size, one_in(stream, 8) ? ";a=\"b\"" : "",
                        body.substr(at, size));
    at += size;
  }
  return text + "0\r\n" + (one_in(stream, 8) ? "Host: evil.example\r\n" : "") + "\r\n";
}

inline std::string random_fields(bool is_post, random::Stream& stream) {
  constexpr std::array<std::string_view, 8> k_hosts{"localhost:7000",
                                                    "[::1]:7000",
                                                    "evil.example",
                                                    "127.0.0.1:7001",
                                                    "",
                                                    "127.0.0.1",
                                                    "LOCALHOST:7000",
                                                    "127.0.0.1:7000, 127.0.0.1:7000"};
  constexpr std::array<std::string_view, 5> k_origins{
      "http://localhost:7000", "null", "http://evil.example", "https://127.0.0.1:7000", ""};
  constexpr std::array<std::string_view, 4> k_sites{"same-origin", "none", "same-site",
                                                    "cross-site"};
  constexpr std::array<std::string_view, 4> k_types{"application/json; charset=utf-8", "text/plain",
                                                    "application/x-www-form-urlencoded", ""};
  constexpr std::array<std::string_view, 8> k_others{
      "Accept: */*\r\n",
      "Connection: close\r\n",
      "Connection: keep-alive, Upgrade\r\nUpgrade: h2c\r\n",
      "Accept-Encoding: gzip, br\r\n",
      "If-None-Match: \"a\"\r\n",
      "Expect: 100-continue\r\n",
      "X: a\r\n folded\r\n",
      "Sec-Fetch-Mode: navigate\r\nSec-Fetch-Dest: document\r\n"};
  std::string fields;
  if (!one_in(stream, 30))
    fields += fmt::format("Host: {}\r\n",
                          one_in(stream, 15) ? one_of(stream, k_hosts) : "127.0.0.1:7000");
  if (one_in(stream, 40)) fields += fmt::format("host:\t{}\r\n", one_of(stream, k_hosts));
  if (!one_in(stream, 15))
    fields +=
        fmt::format("Cookie: {}sleight-7000={}\r\n", one_in(stream, 5) ? "a=b; " : "", k_secret);
  if (is_post != one_in(stream, 15)) {
    fields += fmt::format("Origin: {}\r\n",
                          one_in(stream, 15) ? one_of(stream, k_origins) : "http://127.0.0.1:7000");
    fields += fmt::format("Content-Type: {}\r\n",
                          one_in(stream, 15) ? one_of(stream, k_types) : "application/json");
  }
  if (one_in(stream, 3)) fields += fmt::format("Sec-Fetch-Site: {}\r\n", one_of(stream, k_sites));
  while (one_in(stream, 2))
    fields += one_of(stream, k_others);
  if (one_in(stream, 50))
    fields += fmt::format("Long: {}\r\n", std::string(below(stream, 6000), 'a'));
  return fields;
}

inline std::string random_request(random::Stream& stream) {
  constexpr std::array<std::string_view, 5> k_methods{"HEAD", "PUT", "OPTIONS", "get", "G\x01T"};
  constexpr std::array<std::string_view, 16> k_targets{
      "/",
      "/index.html",
      "/api/gallery",
      "/api/events",
      "/api/archives/0/animations?names=0.250,0.300",
      "/?token=7777777777777777777777777777777777777777777777777777777777777777",
      "/?token=used",
      "/a/../b",
      "/%2e%2e/a",
      "/%00",
      "/a%2fb",
      "/a\\b",
      "http://127.0.0.1:7000/",
      "*",
      "/%ff",
      "//a?b=%"};
  const bool is_post = one_in(stream, 3);
  std::string_view method = is_post ? "POST" : "GET";
  if (one_in(stream, 15)) method = one_of(stream, k_methods);
  std::string text = fmt::format("{} {} HTTP/1.{}\r\n{}", method,
                                 one_in(stream, 2) ? "/api/find" : one_of(stream, k_targets),
                                 one_in(stream, 20) ? 0 : 1, random_fields(is_post, stream));
  if (!is_post && !one_in(stream, 20)) return text + "\r\n";
  const std::string body = random_body(stream);
  const bool is_chunked = one_in(stream, 8);
  if (is_chunked != one_in(stream, 20)) text += "Transfer-Encoding: chunked\r\n";
  if (!is_chunked || one_in(stream, 20)) {
    constexpr std::array<std::string_view, 6> k_lengths{"0",    "-1",  "4294967296",
                                                        "0x10", "5,5", "18446744073709551616"};
    text += "Content-Length: ";
    if (one_in(stream, 20)) {
      text += one_of(stream, k_lengths);
    } else {
      text += std::to_string(body.size());
    }
    text += "\r\n";
  }
  return text + "\r\n" + (is_chunked ? chunked(body, stream) : body);
}

/// Returns one to four requests. In a quarter of cases, some bytes are changed, removed or doubled.
inline std::string random_connection(random::Stream& stream) {
  std::string bytes;
  for (std::uint64_t i = 1 + below(stream, 4); i > 0; --i)
    bytes += random_request(stream);
  if (!one_in(stream, 4)) return bytes;
  for (std::uint64_t i = 1 + below(stream, 4); i > 0 && !bytes.empty(); --i) {
    const std::size_t at = below(stream, bytes.size());
    const std::size_t count = std::min<std::size_t>(1 + below(stream, 20), bytes.size() - at);
    constexpr std::string_view k_signs("\0\r\n :,;%/\\\xff\t", 12);
    switch (below(stream, 4)) {
      case 0:
        bytes[at] = static_cast<char>(below(stream, 256));
        break;
      case 1:
        bytes.insert(at, 1, k_signs[below(stream, k_signs.size())]);
        break;
      case 2:
        bytes.erase(at, count);
        break;
      default:
        bytes.insert(at, bytes.substr(at, count));
    }
  }
  return bytes;
}

}  // namespace sleight::web::testing
