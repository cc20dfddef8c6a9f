// Verifies the results of benchmarks: each benchmark compares a hash of its results with a known
// hash.
#pragma once

#include <benchmark/benchmark.h>

#include <cstdint>
#include <cstring>

namespace sleight::bench {

/// FNV-1a over the bits of results, in order.
class ResultHash {
 public:
  void add(double value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof(bits));
    add(bits);
  }
  void add(std::uint64_t bits) {
    for (int i = 0; i < 8; ++i) {
      value_ = (value_ ^ (bits >> (8 * i) & 0xff)) * 0x100000001b3U;
    }
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325U;
};

/// Compares the hash of a fixed piece of work with the known hash. If they differ, the benchmark
/// and the whole program fail. REQUIRES: called once for each run of a benchmark.
void verify(benchmark::State& state, std::uint64_t hash, std::uint64_t expected);

bool any_wrong();

}  // namespace sleight::bench
