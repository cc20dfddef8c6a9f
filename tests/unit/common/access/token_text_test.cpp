// Goal: a written token reads back equal, altered tokens are refused, and different tokens have
// different hashes. Method: change each character of a token, swap neighbouring characters, and cut
// the token at each character.
#include "common/access/token_text.h"

#include <gtest/gtest.h>

#include <set>

namespace sleight::access {
namespace {

TEST(TokenTextTest, IsReadBackAsItWasWritten) {
  std::set<std::string> texts;
  for (int i = 0; i < 1000; ++i) {
    const Token token = draw_token();
    const std::string text = text_of(token);
    ASSERT_EQ(text.size(), k_token_characters);
    ASSERT_TRUE(text.starts_with("sleight_" + token.id + "_")) << text;
    const auto read = token_of(text);
    ASSERT_TRUE(read.has_value()) << text;
    EXPECT_EQ(read->id, token.id);
    EXPECT_EQ(read->secret, token.secret);
    EXPECT_TRUE(is_token_id(token.id));
    texts.insert(text);
  }
  EXPECT_EQ(texts.size(), 1000U);
}

TEST(TokenTextTest, AnyChangeOfACharacterIsFound) {
  const std::string text = text_of(draw_token());
  for (std::size_t place = 0; place < text.size(); ++place) {
    for (const char c : std::string("0123456789abcdefghjkmnpqrstvwxyzilouABC_ -\0\n\xff", 46)) {
      if (c == text[place]) continue;
      std::string other = text;
      other[place] = c;
      EXPECT_FALSE(token_of(other).has_value()) << other;
    }
    EXPECT_FALSE(token_of(text.substr(0, place)).has_value());
    if (place > 0 && text[place] != text[place - 1]) {
      std::string other = text;
      std::swap(other[place], other[place - 1]);
      EXPECT_FALSE(token_of(other).has_value()) << other;
    }
  }
  EXPECT_FALSE(token_of(text + "0").has_value());
  EXPECT_FALSE(token_of("").has_value());
  EXPECT_FALSE(token_of(std::string(1U << 20U, 'a')).has_value());
}

TEST(TokenTextTest, HashesTellTokensApart) {
  const Token token = draw_token();
  Token other_id = token;
  other_id.id = draw_token().id;
  Token other_secret = token;
  other_secret.secret[31] ^= std::byte{0x10};
  EXPECT_EQ(hash_of(token).size(), 64U);
  EXPECT_TRUE(are_equal_hashes(hash_of(token), hash_of(*token_of(text_of(token)))));
  EXPECT_FALSE(are_equal_hashes(hash_of(token), hash_of(other_id)));
  EXPECT_FALSE(are_equal_hashes(hash_of(token), hash_of(other_secret)));
  EXPECT_FALSE(are_equal_hashes(hash_of(token), ""));
}

TEST(TokenTextTest, IdsAreTenCharacters) {
  EXPECT_TRUE(is_token_id("0123456789"));
  for (const char* id : {"", "012345678", "01234567890", "012345678I", "../../../x", "012345678\n"})
    EXPECT_FALSE(is_token_id(id)) << id;
}

}  // namespace
}  // namespace sleight::access
