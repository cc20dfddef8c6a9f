// Values that a server should never receive: extreme numbers, hostile texts, invalid tokens. Equal
// Dice give equal values. Thread safety: one Dice belongs to one thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "common/random/stream.h"

namespace sleight::attack {

/// The random choices of one episode.
class Dice {
 public:
  Dice(std::uint64_t seed, std::uint64_t episode)
      : stream_({.seed = seed, .purpose = random::Purpose::search}, episode) {}

  std::uint64_t bits() { return stream_.bits(); }
  /// A number from 0 to `count` - 1. REQUIRES: count > 0.
  std::uint64_t below(std::uint64_t count) { return stream_.bits() % count; }
  std::uint32_t below32(std::uint32_t count) {
    return static_cast<std::uint32_t>(stream_.bits() % count);
  }
  bool one_in(std::uint64_t count) { return below(count) == 0; }
  double uniform() { return stream_.uniform(); }

 private:
  random::Stream stream_;
};

std::string random_bytes(Dice& dice, std::size_t size);
/// Returns 0, 1, the maximum, a number close to a power of two, or any number.
std::uint64_t odd_number(Dice& dice);
/// NaN, infinite, tiny, or negative.
double odd_real(Dice& dice);
/// Returns 0, or a number far beyond all job ids.
std::uint64_t far_id(Dice& dice);
/// An odd text: empty, or with `../`, control characters, invalid UTF-8 or format strings. One text
/// in a thousand has `bytes_max` or half of `bytes_max` bytes.
std::string odd_text(Dice& dice, std::size_t bytes_max);
/// An invalid request: deeply nested, with very long names, or too expensive.
std::string odd_request(Dice& dice, std::size_t bytes_max);
/// An invalid token that resembles `real` or any other token.
std::string wrong_token(Dice& dice, const std::string& real);

}  // namespace sleight::attack
