// What a connection's bytes come to, by what a server runs (intake.h, guard.h, reply.h), with all
// checked that must hold of any bytes: for tests and the fuzzer.
//
//   - No ask passes that a second reader, slow and plain, doesn't read likewise: the same method,
//   path
//     and body, one Host of ours, and the secret in a Cookie or a token in the target.
//   - It makes no difference in which pieces the bytes come.
//   - What is held never exceeds its bounds, and nothing is left in the end.
//   - What is sent has the lines that it should have, and nothing of what was asked.
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
/// Lets in once.
inline constexpr std::string_view k_token =
    "7777777777777777777777777777777777777777777777777777777777777777";

inline constexpr IntakeLimits k_limits{.head_bytes_max = 4096, .body_bytes_max = 10'000};
inline constexpr std::size_t k_bodies_bytes_max = 30'000;

/// A request that passed.
struct Taken {
  Passed passed{};
  bool keeps_open = false;
};

struct Outcome {
  std::vector<Taken> taken{};
  unsigned refused = 0;  ///< with this status, or 0
  std::string sent{};    ///< heads of all answers
};

/// Bytes that come in pieces of this size.
Outcome exchange_in_pieces(std::string_view bytes, std::size_t piece);

/// The same, with everything checked. REQUIRES: piece > 0.
Outcome checked_exchange(std::string_view bytes, std::size_t piece);

/// A request as the second reader has it.
struct PlainRequest {
  std::string method{};
  std::string target{};
  std::vector<std::string> hosts{};
  std::vector<std::string> cookies{};
  std::string body{};
  std::size_t size = 0;  ///< bytes that it takes
};
/// None where these bytes don't begin with a request that is whole and plain.
std::vector<PlainRequest> read_plainly(std::string_view bytes);

}  // namespace sleight::web::testing
