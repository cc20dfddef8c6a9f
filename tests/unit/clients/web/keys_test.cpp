// Goal: generated secrets differ, and each token works only once. Method: compare a hundred
// secrets. Use a token twice. Use a token that newer tokens have displaced. Use one token in two
// threads.
#include "clients/web/keys.h"

#include <gtest/gtest.h>

#include <atomic>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "common/base/error.h"

namespace sleight::web {
namespace {

TEST(Keys, SecretsDiffer) {
  std::set<std::string> secrets;
  for (int i = 0; i < 100; ++i) {
    const std::string secret = new_secret();
    EXPECT_EQ(secret.size(), k_secret_digits);
    EXPECT_EQ(secret.find_first_not_of("0123456789abcdef"), std::string::npos);
    secrets.insert(secret);
  }
  EXPECT_EQ(secrets.size(), 100U);
}

TEST(Keys, AreComparedAsTexts) {
  EXPECT_TRUE(is_same("", ""));
  EXPECT_TRUE(is_same("abc", "abc"));
  EXPECT_FALSE(is_same("abc", "abd"));
  EXPECT_FALSE(is_same("abc", "bbc"));
  EXPECT_FALSE(is_same("abc", "abcd"));
  EXPECT_FALSE(is_same("abc", ""));
  EXPECT_FALSE(is_same(std::string_view("a\0b", 3), std::string_view("a\0c", 3)));
  EXPECT_FALSE(is_same("\x80", std::string_view("\0", 1)));
}

TEST(Keys, TokensHoldOnce) {
  Keys keys;
  const std::string token = keys.new_token();
  EXPECT_NE(token, keys.secret());
  EXPECT_FALSE(keys.use(""));
  EXPECT_FALSE(keys.use(keys.secret()));
  EXPECT_FALSE(keys.use(token.substr(1)));
  EXPECT_TRUE(keys.use(token));
  EXPECT_FALSE(keys.use(token));
}

TEST(Keys, TheOldestTokenGoes) {
  Keys keys;
  std::vector<std::string> tokens;
  for (std::size_t i = 0; i <= k_tokens_max; ++i)
    tokens.push_back(keys.new_token());
  EXPECT_FALSE(keys.use(tokens.front()));
  for (std::size_t i = 1; i < tokens.size(); ++i)
    EXPECT_TRUE(keys.use(tokens[i]));
}

TEST(Keys, OneOfTwoThreadsHasTheToken) {
  Keys keys;
  for (int i = 0; i < 50; ++i) {
    const std::string token = keys.new_token();
    std::atomic<int> let_in = 0;
    const auto use = [&] {
      if (keys.use(token)) ++let_in;
    };
    std::thread other(use);
    use();
    other.join();
    EXPECT_EQ(let_in, 1);
  }
}

TEST(Keys, ASecretOfBeforeIsTakenIfItIsOne) {
  const std::string secret = new_secret();
  EXPECT_EQ(Keys(secret).secret(), secret);
  EXPECT_EQ(Keys().secret().size(), k_secret_digits);
  Keys with_token(secret, {"unused"});
  EXPECT_TRUE(with_token.use("unused"));
  EXPECT_FALSE(with_token.use("unused"));
  EXPECT_THROW(Keys("short"), base::Error);
  EXPECT_THROW(Keys(std::string(k_secret_digits, 'g')), base::Error);
  EXPECT_THROW(Keys(std::string(k_secret_digits, ';')), base::Error);
}

}  // namespace
}  // namespace sleight::web
