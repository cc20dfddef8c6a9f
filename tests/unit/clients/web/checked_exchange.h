// Passes a connection's bytes through the server's parts (intake.h, guard.h, reply.h) and checks
// properties that hold for any bytes. Tests and the fuzzer use it.
//
//   - If the server accepts a request, a slow and plain second reader finds the same method, path
//     and body. The second reader also finds one Host header, which names this server, and the
//     secret in a Cookie or a token in the target.
//   - The result doesn't depend on the pieces in which bytes arrive.
//   - The number of buffered bytes never exceeds its limits, and is 0 at the end.
//   - Answers have the right header lines and repeat no part of the request.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "clients/web/intake.h"

namespace sleight::web::testing {

inline constexpr std::string_view k_secret =
    "5555555555555555555555555555555555555555555555555555555555555555";
inline constexpr std::uint16_t k_port = 7000;
/// This token authorizes a browser once.
inline constexpr std::string_view k_token =
    "7777777777777777777777777777777777777777777777777777777777777777";

inline constexpr IntakeLimits k_limits{.head_bytes_max = 4096, .body_bytes_max = 10'000};
inline constexpr std::size_t k_bodies_bytes_max = 30'000;

struct Taken {
  Passed passed{};
  bool keeps_open = false;
};

struct Outcome {
  std::vector<Taken> taken{};
  unsigned refused = 0;  ///< status of the refusal, or 0
  std::string sent{};    ///< heads of all answers
};

Outcome exchange_in_pieces(std::string_view bytes, std::size_t piece);

/// Passes `bytes` whole and in pieces, and checks the properties listed above. REQUIRES: piece > 0.
Outcome checked_exchange(std::string_view bytes, std::size_t piece);

struct PlainRequest {
  std::string method{};
  std::string target{};
  std::vector<std::string> hosts{};
  std::vector<std::string> cookies{};
  std::string body{};
  std::size_t size = 0;  ///< its length in bytes
};
/// Returns nothing if the bytes don't begin with a complete, plain request.
std::vector<PlainRequest> read_plainly(std::string_view bytes);

}  // namespace sleight::web::testing
