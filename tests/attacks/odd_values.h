// Values that a server should never have to see: extreme numbers, hostile texts, tokens that are
// none. All are functions of their Dice, so that an attack is seen again by its number.
//
// Thread safety: one Dice belongs to one thread.
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
  /// 0 to `count` - 1. REQUIRES: count > 0.
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
/// 0, 1, powers of two and their neighbours, the greatest, anything.
std::uint64_t odd_number(Dice& dice);
/// Not a number, infinite, tiny, negative.
double odd_real(Dice& dice);
/// An id that no job has, also with one or two of its bytes changed; or 0.
std::uint64_t far_id(Dice& dice);
/// Empty, `../`, control characters, bytes that are no UTF-8, formats; one in a thousand is as
/// long as `bytes_max` allows.
std::string odd_text(Dice& dice, std::size_t bytes_max);
/// Texts of requests that are refused: deep nesting, endless names, one that is too dear.
std::string odd_request(Dice& dice, std::size_t bytes_max);
/// Like `real`, or like any token, but not valid.
std::string wrong_token(Dice& dice, const std::string& real);

}  // namespace sleight::attack
