#include "common/hash/sha256.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>

namespace sleight::hash {
namespace {

// NIST's published examples of SHA-256 (FIPS 180-4, Secure Hash Standard).
constexpr const char* k_of_nothing =
    "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
constexpr const char* k_of_abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
constexpr const char* k_of_two_blocks =
    "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1";
constexpr const char* k_of_million_a =
    "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0";
constexpr const char* k_two_blocks = "abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq";

TEST(Sha256, KnownAnswers) {
  // Goal: the hashes of the standard's examples equal the published hashes.
  EXPECT_EQ(sha256_hex(""), k_of_nothing);
  EXPECT_EQ(sha256_hex("abc"), k_of_abc);
  EXPECT_EQ(sha256_hex(k_two_blocks), k_of_two_blocks);
  EXPECT_EQ(sha256_hex(std::string(1000000, 'a')), k_of_million_a);
}

TEST(Sha256, DoesNotKnowHowContentWasCut) {
  // Goal: a text that is hashed in pieces of any size has the same hash as the whole text.
  const std::string all(1000000, 'a');
  for (const std::size_t piece : {1U, 63U, 64U, 65U, 4096U, 999999U}) {
    Sha256 hash;
    for (std::size_t at = 0; at < all.size(); at += piece) {
      hash.update(std::string_view(all).substr(at, piece));
      hash.update(std::string_view());
    }
    EXPECT_EQ(to_hex(hash.finish()), k_of_million_a) << piece;
  }
}

TEST(Sha256, MovesWithWhatItHasTakenIn) {
  // Goal: an unfinished hash can be moved and then continued.
  Sha256 first;
  first.update("a");
  Sha256 second(std::move(first));
  second.update("b");
  Sha256 third;
  third.update("something else");
  third = std::move(second);
  third.update("c");
  EXPECT_EQ(to_hex(third.finish()), k_of_abc);
}

}  // namespace
}  // namespace sleight::hash
