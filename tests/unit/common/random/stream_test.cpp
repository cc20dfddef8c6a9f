// Goal: a stream returns the words of Philox4x64-10 at its address (see stream.h), and depends on
// nothing else. Method: compare with the known answers of Random123. Compare with a reference that
// follows the paper. Change each bit of the address. Test statistics over neighbouring addresses.
#include "common/random/stream.h"

#include <Random123/philox.h>
#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "tests/unit/common/random/chi_square.h"

namespace sleight::random {
namespace {

using Counter = std::array<std::uint64_t, 4>;
using Key = std::array<std::uint64_t, 2>;
__extension__ using Wide = unsigned __int128;

// Computes Philox4x64-10 as the paper describes. There are ten rounds, and Weyl constants are added
// to the key between rounds.
Counter reference_philox(Counter counter, Key key) {
  for (int round = 0; round < 10; ++round) {
    const Wide even = Wide{0xD2E7470EE14C6C93} * counter[0];
    const Wide odd = Wide{0xCA5A826395121157} * counter[2];
    counter = {static_cast<std::uint64_t>(odd >> 64) ^ counter[1] ^ key[0],
               static_cast<std::uint64_t>(odd),
               static_cast<std::uint64_t>(even >> 64) ^ counter[3] ^ key[1],
               static_cast<std::uint64_t>(even)};
    key[0] += 0x9E3779B97F4A7C15;
    key[1] += 0xBB67AE8584CAA73B;
  }
  return counter;
}

struct KnownAnswer {
  Counter counter;
  Key key;
  Counter answer;
};

// The "philox4x64 10" lines of the file examples/kat_vectors, which Random123 publishes.
const std::vector<KnownAnswer> k_known_answers = {
    {{0, 0, 0, 0},
     {0, 0},
     {0x16554d9eca36314c, 0xdb20fe9d672d0fdc, 0xd7e772cee186176b, 0x7e68b68aec7ba23b}},
    {{~0ULL, ~0ULL, ~0ULL, ~0ULL},
     {~0ULL, ~0ULL},
     {0x87b092c3013fe90b, 0x438c3c67be8d0224, 0x9cc7d7c69cd777b6, 0xa09caebf594f0ba0}},
    {{0x243f6a8885a308d3, 0x13198a2e03707344, 0xa4093822299f31d0, 0x082efa98ec4e6c89},
     {0x452821e638d01377, 0xbe5466cf34e90c6c},
     {0xa528f45403e61d95, 0x38c72dbd566e9788, 0xa5a1610e72fd18b5, 0x57bd43b5e52b7fe6}},
};

TEST(Philox, gives_the_published_known_answers) {
  for (const auto& [counter, key, answer] : k_known_answers) {
    EXPECT_EQ(reference_philox(counter, key), answer);
    const auto words = r123::Philox4x64_R<10>{}({{counter[0], counter[1], counter[2], counter[3]}},
                                                {{key[0], key[1]}});
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_EQ(words[i], answer[i]);
  }
}

StreamKey sample_key() {
  return {.seed = 0x0123456789abcdef,
          .chain = base::ChainId{0xfedcba98},
          .replica = base::ReplicaId{0x76543210},
          .purpose = Purpose::acceptance};
}

TEST(Stream, is_philox_at_its_address) {
  const StreamKey key = sample_key();
  constexpr std::uint64_t k_iteration = 0xaaaabbbbccccdddd;
  Stream stream(key, k_iteration);
  for (std::uint64_t block = 0; block < 1000; ++block) {
    const Counter expected =
        reference_philox({block, k_iteration, 3, 0}, {0x0123456789abcdef, 0xfedcba9876543210});
    for (const std::uint64_t word : expected)
      ASSERT_EQ(stream.bits(), word) << "block " << block;
  }
}

TEST(Stream, depends_on_every_bit_of_every_field) {
  std::set<std::uint64_t> first_words = {Stream(sample_key(), 7).bits()};
  std::size_t addresses = 1;
  const auto add = [&](const StreamKey& key, std::uint64_t iteration) {
    first_words.insert(Stream(key, iteration).bits());
    ++addresses;
  };
  for (int bit = 0; bit < 64; ++bit) {
    StreamKey key = sample_key();
    key.seed ^= std::uint64_t{1} << bit;
    add(key, 7);
    add(sample_key(), 7 ^ std::uint64_t{1} << bit);
  }
  for (int bit = 0; bit < 32; ++bit) {
    StreamKey key = sample_key();
    key.chain.value ^= std::uint32_t{1} << bit;
    add(key, 7);
    key = sample_key();
    key.replica.value ^= std::uint32_t{1} << bit;
    add(key, 7);
  }
  for (const Purpose purpose : {Purpose::prior, Purpose::proposal, Purpose::swap}) {
    StreamKey key = sample_key();
    key.purpose = purpose;
    add(key, 7);
  }
  EXPECT_EQ(first_words.size(), addresses);
}

TEST(Stream, is_uniform_across_neighbouring_addresses) {
  // Samplers take few words from each stream, so take one word from each of many streams.
  const auto judge = [](const char* name, auto stream_at) {
    std::vector<int> high(256);
    std::vector<int> low(256);
    for (std::uint64_t i = 0; i < k_draws; ++i) {
      const std::uint64_t word = stream_at(i).bits();
      ++high[word >> 56];
      ++low[word & 255];
    }
    expect_plausible(chi_square_p_value(high), std::string(name) + ", high byte");
    expect_plausible(chi_square_p_value(low), std::string(name) + ", low byte");
  };
  StreamKey key{.seed = 1, .purpose = Purpose::proposal};
  judge("iterations", [=](std::uint64_t i) { return Stream(key, i); });
  judge("chains", [=](std::uint64_t i) mutable {
    key.chain.value = static_cast<std::uint32_t>(i);
    return Stream(key, 0);
  });
  judge("replicas", [=](std::uint64_t i) mutable {
    key.replica.value = static_cast<std::uint32_t>(i);
    return Stream(key, 0);
  });
  judge("seeds", [=](std::uint64_t i) mutable {
    key.seed = i;
    return Stream(key, 0);
  });
}

TEST(Stream, uniform_is_the_midpoint_of_its_words_top_bits) {
  Stream words(sample_key(), 0);
  Stream stream(sample_key(), 0);
  std::vector<int> counts(256);
  for (int i = 0; i < k_draws; ++i) {
    const double u = stream.uniform();
    ASSERT_EQ(u, (static_cast<double>(words.bits() >> 12) + 0.5) / 4503599627370496.0);
    ASSERT_GT(u, 0);
    ASSERT_LT(u, 1);
    ++counts[static_cast<std::size_t>(256 * u)];
  }
  expect_plausible(chi_square_p_value(counts), "uniform");
}

TEST(StreamDeathTest, refuses_a_key_that_names_no_purpose) {
  EXPECT_DEATH(Stream({.seed = 1}, 0), "check failed");
}

}  // namespace
}  // namespace sleight::random
