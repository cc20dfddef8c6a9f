#include "common/schema/messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/common/schema/examples.h"

namespace sleight::schema {
namespace {

using ::testing::HasSubstr;

TEST(Messages, ComeBackBitForBit) {
  // Goal: what a rank receives is what the other sent, in every bit. Method: encode and decode one
  // of every kind and shape.
  const std::vector<Message> all = testing::examples();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const base::Result<Message, std::string> back = decode(encode(all[i]));
    ASSERT_TRUE(back.ok()) << "example " << i << ": " << back.error();
    EXPECT_TRUE(testing::same_bits(back.value(), all[i])) << "example " << i;
  }
}

TEST(Messages, ComparerSeesOneBit) {
  // Goal: same_bits can fail. Method: zero of the other sign, another payload, another kind.
  plan::UnitResult a = testing::example_result(1);
  a.scans[0].outcome = {0.0};
  plan::UnitResult b = a;
  EXPECT_TRUE(testing::same_bits(a, b));
  b.scans[0].outcome = {-0.0};
  EXPECT_FALSE(testing::same_bits(a, b));
  b = a;
  b.state_after.back() ^= std::byte{1};
  EXPECT_FALSE(testing::same_bits(a, b));
  EXPECT_FALSE(testing::same_bits(Stop{}, Failure{}));
}

TEST(Messages, EncodingIsAFunctionOfTheMessage) {
  // Goal: equal messages are equal bytes. Method: encode twice.
  for (const Message& message : testing::examples())
    EXPECT_EQ(encode(message), encode(message));
}

TEST(Messages, ResultOfAnotherLengthIsRefused) {
  // Goal: a result never carries more or fewer scans than its unit says. Method: one more, one
  // less, none, and scans for a unit of none.
  for (const std::uint32_t claimed : {0U, 2U, 4U, 0xffffffffU}) {
    plan::UnitResult result = testing::example_result(3);
    result.unit.scans = claimed;
    const auto back = decode(encode(result));
    ASSERT_FALSE(back.ok()) << claimed;
    EXPECT_THAT(back.error(), HasSubstr("number of scans"));
  }
}

TEST(Messages, AssignmentOfNoScansIsRefused) {
  // Goal: a worker never gets a unit that it must not run. Method: an assignment of 0 scans.
  const auto back = decode(encode(Assignment{}));
  ASSERT_FALSE(back.ok());
  EXPECT_THAT(back.error(), HasSubstr("no scans"));
}

TEST(Messages, PiecesOfNothingAreRefused) {
  // Goal: lengths that can't be a message are refused before reading. Method: no bytes, and one
  // byte more or less than a message.
  EXPECT_FALSE(decode({}).ok());
  const base::Bytes whole = encode(testing::example_result(2));
  EXPECT_FALSE(decode(base::BytesView(whole).first(whole.size() - 1)).ok());
  base::Bytes longer = whole;
  longer.push_back(std::byte{0});
  EXPECT_FALSE(decode(longer).ok());
}

TEST(Messages, AreReadAtAnyAddress) {
  // Goal: bytes need no alignment. Method: the same message at eight neighbouring addresses.
  const Message message = testing::example_result(3);
  const base::Bytes bytes = encode(message);
  for (std::size_t offset = 0; offset < 8; ++offset) {
    base::Bytes moved(offset);
    moved.insert(moved.end(), bytes.begin(), bytes.end());
    const auto back = decode(base::BytesView(moved).subspan(offset));
    ASSERT_TRUE(back.ok());
    EXPECT_TRUE(testing::same_bits(back.value(), message));
  }
}

}  // namespace
}  // namespace sleight::schema
