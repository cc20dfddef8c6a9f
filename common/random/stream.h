// Random numbers by address: a function of (seed, chain, replica, purpose, iteration, position).
//
// Idea. There is no "next random number". Code that needs randomness names the purpose and
// constructs a Stream. The numbers come from Philox4x64-10, a keyed bijection on 256-bit counters
// (Salmon, Moraes, Dror and Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC11;
// implementation: Random123). So a unit of work recomputed on another machine, or in another order,
// draws the same values, and no generator state is ever stored or sent.
//
//   key     = (seed, chain * 2^32 + replica)
//   counter = (block, iteration, purpose, 0), block = 0, 1, 2, ...
//
// Each block has four 64-bit words, used in order.
//
// Invariants
//   1. The n-th word of a Stream depends on its address and n alone.
//   2. Different addresses never use the same key and counter, because the map above is one to one.
//      Philox was built and tested to return independent words for neighbouring keys and counters
//      (BigCrush, in the paper).
//   3. The map, and the order of words, are part of the archive's meaning: changing either changes
//      every run. tests/unit/common/random pins golden values.
// An address has at most 2^66 words. No program reaches this limit, so a Stream does not check for
// it. Thread safety: distinct Streams are independent; a Stream must not be shared between threads.
#pragma once

#include <array>
#include <cstdint>

#include "common/base/ids.h"
#include "common/random/purpose.h"

namespace sleight::random {

/// A stream's address without the iteration. `purpose` must be set.
struct StreamKey {
  std::uint64_t seed = 0;
  base::ChainId chain{};
  base::ReplicaId replica{};
  Purpose purpose{};
};

/// A Stream is a value of 72 bytes and allocates no memory. The first draw computes four words.
class Stream {
 public:
  Stream(const StreamKey& key, std::uint64_t iteration);

  /// Returns 64 uniform bits.
  std::uint64_t bits() {
    if (next_ == words_.size()) refill();
    return words_[next_++];
  }

  /// Uniform on the open interval (0, 1): one of the 2^52 numbers (k + 1/2) 2^-52, all equally
  /// likely. The numbers exclude 0 and 1, and are symmetric about 1/2. Uses one word.
  double uniform() {
    const auto k = static_cast<double>(bits() >> 12);
    return (k + 0.5) * 0x1p-52;
  }

 private:
  void refill();

  std::array<std::uint64_t, 4> words_{};
  std::uint64_t seed_;
  std::uint64_t lane_;  ///< Chain and replica.
  std::uint64_t block_ = 0;
  std::uint64_t iteration_;
  Purpose purpose_;
  std::uint32_t next_ = 4;  ///< Index into words_; 4 when all are used.
};

}  // namespace sleight::random
