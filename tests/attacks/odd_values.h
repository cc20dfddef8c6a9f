// Values that a server should never receive: extreme numbers, hostile texts, invalid tokens. All
// are functions of their Dice and so repeatable. Thread safety: one Dice belongs to one thread.
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
/// 0, 1, powers of two and their neighbours, the maximum, or any number.
std::uint64_t odd_number(Dice& dice);
/// NaN, infinite, tiny, or negative.
double odd_real(Dice& dice);
/// An id that no job has, possibly with one or two bytes changed; or 0.
std::uint64_t far_id(Dice& dice);
/// An odd text: empty, with `../`, control characters, invalid UTF-8 or format strings; one in a
/// thousand has half or all of `bytes_max`.
std::string odd_text(Dice& dice, std::size_t bytes_max);
/// Invalid requests: deep nesting, endless names, or one that is too expensive.
std::string odd_request(Dice& dice, std::size_t bytes_max);
/// An invalid token that resembles `real` or any other token.
std::string wrong_token(Dice& dice, const std::string& real);

}  // namespace sleight::attack
