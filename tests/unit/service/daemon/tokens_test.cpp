// Goal: a token authorizes its user until it is revoked or expires, even if the daemon restarts.
// The token file doesn't contain the tokens' secrets. Method: move a simulated clock. A new object
// that reads the same file acts as the restarted daemon.
#include "service/daemon/tokens.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>

#include "common/access/token_text.h"
#include "common/base/error.h"

namespace sleight::daemon {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class TokensTest : public ::testing::Test {
 protected:
  TokensTest()
      : folder_(std::filesystem::temp_directory_path() /
                ("tokens-" + std::to_string(::getpid()) + "-" +
                 ::testing::UnitTest::GetInstance()->current_test_info()->name())) {
    std::filesystem::create_directories(folder_);
    begin();
  }
  ~TokensTest() override { std::filesystem::remove_all(folder_); }

  void begin() {
    tokens_ = std::make_unique<Tokens>(files_, path(), [this] { return now_s_; });
  }
  std::string path() const { return folder_ / "tokens.json"; }
  std::string content() const { return base::read_text_file(path(), 1U << 20U); }
  static rpc::TokenAsk ask(const std::string& text, double valid_s = 100) {
    rpc::TokenAsk made{.token = text, .name = "laptop", .valid_s = valid_s};
    made.scopes.add(rpc::Scope::read);
    return made;
  }
  static std::string draw() { return access::text_of(access::draw_token()); }
  bool is_let_in(const std::string& text) { return tokens_->login(text, "192.0.2.7:5").ok(); }

  base::PosixFileSystem files_;
  double now_s_ = 1'000'000;
  std::filesystem::path folder_;
  std::unique_ptr<Tokens> tokens_;
};

TEST_F(TokensTest, LetsItsUserIn) {
  const std::string text = draw();
  rpc::TokenAsk asked = ask(text);
  asked.for_user = 4002;
  asked.jobs_max = 3;
  asked.cores_max = 2;
  const auto made = tokens_->create(4001, asked);
  ASSERT_TRUE(made.ok());
  EXPECT_EQ(made.value().user, 4002U);
  EXPECT_EQ(made.value().expires_s, now_s_ + 100);
  const auto caller = tokens_->login(text, "192.0.2.7:5");
  ASSERT_TRUE(caller.ok());
  EXPECT_EQ(caller.value().user, 4002U);
  EXPECT_EQ(caller.value().token_id, made.value().id);
  EXPECT_TRUE(caller.value().scopes.has(rpc::Scope::read));
  EXPECT_FALSE(caller.value().scopes.has(rpc::Scope::submit));
  EXPECT_EQ(caller.value().token_jobs_max, 3U);
  EXPECT_EQ(caller.value().token_cores_max, 2U);
  EXPECT_TRUE(tokens_->lets_go_on(caller.value()));
}

TEST_F(TokensTest, TheFileHoldsNoSecret) {
  const std::string text = draw();
  ASSERT_TRUE(tokens_->create(4001, ask(text)).ok());
  EXPECT_THAT(content(), HasSubstr(access::token_of(text)->id));
  const std::string secret = text.substr(text.find('_', 9) + 1);
  EXPECT_THAT(content(), Not(HasSubstr(secret.substr(0, 12))));
}

TEST_F(TokensTest, EndsWhenItsTimeIsOver) {
  const std::string text = draw();
  ASSERT_TRUE(tokens_->create(4001, ask(text)).ok());
  const auto caller = tokens_->login(text, "a");
  now_s_ += 99.9;
  EXPECT_TRUE(tokens_->lets_go_on(caller.value()));
  now_s_ += 0.1;
  EXPECT_FALSE(tokens_->lets_go_on(caller.value()));
  EXPECT_FALSE(is_let_in(text));
  const std::string for_ever = draw();
  ASSERT_TRUE(tokens_->create(4001, ask(for_ever, 0)).ok());
  now_s_ += 1e9;
  EXPECT_TRUE(is_let_in(for_ever));
}

TEST_F(TokensTest, AClockThatIsSetBackRevivesNone) {
  const std::string used = draw();
  const std::string unused = draw();
  ASSERT_TRUE(tokens_->create(4001, ask(used)).ok());
  ASSERT_TRUE(tokens_->create(4001, ask(unused)).ok());
  now_s_ += 101;
  EXPECT_FALSE(is_let_in(used));
  tokens_->save_uses();  // checks all tokens, as the daemon does each minute
  now_s_ -= 100'000;
  EXPECT_FALSE(is_let_in(used));
  EXPECT_FALSE(is_let_in(unused));
  begin();
  EXPECT_FALSE(is_let_in(used));
  EXPECT_FALSE(is_let_in(unused));
  EXPECT_TRUE(tokens_->of(4001).front().has_expired);
}

TEST_F(TokensTest, SurvivesADaemonAndIsRevokedForGood) {
  const std::string kept = draw();
  const std::string revoked = draw();
  ASSERT_TRUE(tokens_->create(4001, ask(kept)).ok());
  const auto made = tokens_->create(4001, ask(revoked));
  begin();
  EXPECT_TRUE(is_let_in(kept));
  const auto session = tokens_->login(revoked, "a");
  ASSERT_TRUE(session.ok());
  ASSERT_TRUE(tokens_->revoke(4001, made.value().id).ok());
  EXPECT_FALSE(tokens_->lets_go_on(session.value()));
  EXPECT_FALSE(is_let_in(revoked));
  begin();
  EXPECT_FALSE(is_let_in(revoked));
  EXPECT_TRUE(is_let_in(kept));
}

// A revocation holds even if the disk can't be written.
TEST_F(TokensTest, IsRevokedAlsoWhereThatCantBeWritten) {
  const std::string text = draw();
  const auto made = tokens_->create(4001, ask(text));
  std::filesystem::create_directory(path() + ".new");  // blocks the temporary file
  EXPECT_THROW(static_cast<void>(tokens_->revoke(4001, made.value().id)), base::Error);
  EXPECT_FALSE(is_let_in(text));
  std::filesystem::remove(path() + ".new");
  // A repeated revocation is stored.
  EXPECT_TRUE(tokens_->revoke(4001, made.value().id).ok());
  begin();
  EXPECT_FALSE(is_let_in(text));
}

TEST_F(TokensTest, OthersTokensAreLikeNone) {
  const auto made = tokens_->create(4001, ask(draw()));
  const auto refused = tokens_->revoke(4002, made.value().id);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().kind, rpc::RefusalKind::not_found);
  EXPECT_TRUE(tokens_->of(4002).empty());
  EXPECT_EQ(tokens_->of(4001).size(), 1U);
  EXPECT_EQ(tokens_->of(std::nullopt).size(), 1U);
}

// Unknown, wrong, revoked and malformed tokens are refused with the same words.
TEST_F(TokensTest, TellsNobodyWhatIsWrong) {
  const std::string revoked = draw();
  const auto made = tokens_->create(4001, ask(revoked));
  ASSERT_TRUE(tokens_->revoke(4001, made.value().id).ok());
  access::Token other = *access::token_of(revoked);
  other.secret[0] ^= std::byte{1};
  const auto words = tokens_->login(draw(), "a").error();
  for (const std::string& text : {revoked, access::text_of(other), std::string("nonsense")})
    EXPECT_EQ(tokens_->login(text, "a").error(), words);
}

TEST_F(TokensTest, ARepeatedCreateMakesNoSecondOne) {
  const std::string text = draw();
  const auto first = tokens_->create(4001, ask(text));
  const auto again = tokens_->create(4001, ask(text));
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(first.value(), again.value());
  EXPECT_EQ(tokens_->of(4001).size(), 1U);
  // If a token's id exists but its user or its secret is another, the token is refused.
  access::Token other = *access::token_of(text);
  other.secret[0] ^= std::byte{1};
  EXPECT_EQ(tokens_->create(4001, ask(access::text_of(other))).error().kind,
            rpc::RefusalKind::conflict);
  EXPECT_EQ(tokens_->create(4002, ask(text)).error().kind, rpc::RefusalKind::conflict);
}

TEST_F(TokensTest, UsesAreSavedNowAndThen) {
  const std::string text = draw();
  ASSERT_TRUE(tokens_->create(4001, ask(text)).ok());
  now_s_ += 10;
  EXPECT_TRUE(is_let_in(text));
  tokens_->save_uses();
  begin();
  EXPECT_EQ(tokens_->of(4001).front().last_used_s, now_s_);
  EXPECT_EQ(tokens_->of(4001).front().last_from, "192.0.2.7:5");
}

TEST_F(TokensTest, WhatIsOverIsForgottenAfterAMonth) {
  ASSERT_TRUE(tokens_->create(4001, ask(draw())).ok());
  now_s_ += 101 + k_over_token_listed_s;
  EXPECT_EQ(tokens_->of(4001).size(), 1U);
  ASSERT_TRUE(tokens_->create(4001, ask(draw())).ok());
  EXPECT_EQ(tokens_->of(4001).size(), 1U);
}

TEST_F(TokensTest, AUserHasSoManyAtMost) {
  tokens_ = std::make_unique<Tokens>(
      files_, path(), [this] { return now_s_; }, 3);
  for (int i = 0; i < 3; ++i)
    ASSERT_TRUE(tokens_->create(4001, ask(draw())).ok());
  EXPECT_EQ(tokens_->create(4001, ask(draw())).error().kind, rpc::RefusalKind::limit);
  EXPECT_TRUE(tokens_->create(4002, ask(draw())).ok());
}

TEST_F(TokensTest, AFileThatIsNoneIsRefusedAndLeft) {
  ASSERT_TRUE(tokens_->create(4001, ask(draw())).ok());
  const std::string good = content();
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string bad = good;
    EXPECT_NE(bad.find(from), std::string::npos) << from;
    return bad.replace(bad.find(from), from.size(), to);
  };
  const std::size_t begin = good.find('{', 1);
  const std::string token = good.substr(begin, good.rfind('}', good.size() - 3) + 1 - begin);
  const std::vector<std::string> all_bad = {"",
                                            good.substr(0, good.size() / 2),
                                            "[]",
                                            R"({"format":2,"tokens":[]})",
                                            R"({"format":1,"tokens":{}})",
                                            R"({"format":1,"tokens":null})",
                                            R"({"format":1,"tokens":[{"id":"../../../x"}]})",
                                            with(R"("user": 4001)", R"("user": 1099511627776)"),
                                            with(R"("user": 4001)", R"("user": 0.5)"),
                                            with(R"("user": 4001)", R"("user": 4294967295)"),
                                            with(R"("revoked": 0.0)", R"("revoked": -1)"),
                                            with(R"("read")", R"("all")"),
                                            with(token, token + "," + token)};
  for (const std::string& bad : all_bad) {
    std::ofstream(path()) << bad;
    EXPECT_THROW(this->begin(), base::Error) << bad;
    EXPECT_EQ(content(), bad);
  }
  std::ofstream(path()) << good;
  EXPECT_NO_THROW(this->begin());
}

}  // namespace
}  // namespace sleight::daemon
