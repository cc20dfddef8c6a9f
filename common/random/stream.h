// Random numbers by address: a function of (seed, chain, replica, purpose, iteration, position).
//
// Idea. Nothing is "the next random number". Code that needs randomness names the purpose and
// builds a Stream on the spot; the numbers come from Philox4x64-10, a keyed bijection on 256-bit
// counters (J. Salmon, M. Moraes, R. Dror, D. Shaw, "Parallel random numbers: as easy as 1, 2, 3",
// SC11; implementation: Random123). So a unit of work recomputed on another machine, or in another
// order, draws the same values, and no generator state is ever stored or sent.
//
//   key     = (seed, chain * 2^32 + replica)
//   counter = (block, iteration, purpose, 0), block = 0, 1, 2, ...
//
// Each block gives four 64-bit words, handed out in order.
//
// Invariants
//   1. The n-th word of a Stream depends on its address and n alone.
//   2. Addresses that differ in any field never use the same key and counter, since the map above
//      is one to one. That such neighbouring keys and counters give independent words is what
//      Philox was built and tested for (BigCrush, in the paper).
//   3. The map, and the order of words, are part of the archive's meaning: changing either changes
//      every run. Golden values in tests/unit/common/random hold it fast.
// Limit: 2^66 words per address, which no program reaches; a Stream does not check for it.
// Thread safety: distinct Streams are independent; one Stream is not shared between threads.
#pragma once

#include <array>
#include <cstdint>

#include "common/base/ids.h"
#include "common/random/purpose.h"

namespace sleight::random {

/// Everything of an address but the iteration. `purpose` must be named.
struct StreamKey {
  std::uint64_t seed = 0;
  base::ChainId chain{};
  base::ReplicaId replica{};
  Purpose purpose{};
};

/// A value: 72 bytes, no allocation, the first four words computed at the first draw.
class Stream {
 public:
  Stream(const StreamKey& key, std::uint64_t iteration);

  /// 64 uniform bits.
  std::uint64_t bits() {
    if (next_ == words_.size()) refill();
    return words_[next_++];
  }

  /// Uniform on the open interval (0, 1): one of the 2^52 numbers (k + 1/2) 2^-52, each as likely.
  /// Never 0 or 1, and u is as likely as 1 - u. Takes one word.
  double uniform() {
    const auto k = static_cast<double>(bits() >> 12);
    return (k + 0.5) * 0x1p-52;
  }

 private:
  void refill();

  std::array<std::uint64_t, 4> words_{};
  std::uint64_t seed_;
  std::uint64_t lane_;  ///< chain and replica
  std::uint64_t block_ = 0;
  std::uint64_t iteration_;
  Purpose purpose_;
  std::uint32_t next_ = 4;  ///< index into words_; 4 when they are used up
};

}  // namespace sleight::random
