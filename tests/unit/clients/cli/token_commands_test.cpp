// Goal: the token commands request tokens with the given options, and show each token once. Tokens
// and the list of known servers are stored in private files. Method: call a real server with a
// scripted handler.
#include "clients/cli/token_commands.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "clients/service_client/known_servers.h"
#include "common/access/token_text.h"
#include "common/base/error.h"
#include "common/json/value.h"
#include "scripted_service.h"

namespace sleight::cli {
namespace {

class TokenCommands : public testing::Test {
 protected:
  TokenCommands() {
    std::string folder = std::filesystem::temp_directory_path() / "sleight-tokens-XXXXXX";
    folder_ = ::mkdtemp(folder.data());
    serving_ = std::make_unique<ServingThread>(socket(), handler_);
  }
  ~TokenCommands() override {
    serving_.reset();
    std::filesystem::remove_all(folder_);
  }
  std::string socket() const { return folder_ / "socket"; }
  std::string file() const { return folder_ / "laptop.token"; }
  template <class Work>
  static std::string out(const Work& work) {
    testing::internal::CaptureStdout();
    EXPECT_EQ(work(), 0);
    return testing::internal::GetCapturedStdout();
  }
  template <class Work>
  static base::ExitCode failure(const Work& work) {
    try {
      work();
    } catch (const base::Error& error) {
      return error.exit_code();
    }
    return base::ExitCode::ok;
  }

  std::filesystem::path folder_;
  ScriptedHandler handler_;
  std::unique_ptr<ServingThread> serving_;
};

TEST_F(TokenCommands, ATokenIsAskedForAndShownOnce) {
  TokenCreateOptions options{.name = "laptop",
                             .scopes = {"read", "operate"},
                             .expires = "2d",
                             .jobs_max = 3,
                             .cores_max = 4};
  std::string text = out([&] { return create_token(socket(), options); });
  ASSERT_TRUE(text.ends_with("\n"));
  text.pop_back();
  ASSERT_TRUE(access::token_of(text).has_value()) << text;
  const rpc::TokenAsk& asked = handler_.asked_token;
  EXPECT_EQ(asked.token, text);
  EXPECT_EQ(asked.name, "laptop");
  EXPECT_EQ(asked.valid_s, 2 * 86400.0);
  EXPECT_EQ(asked.jobs_max, 3U);
  EXPECT_EQ(asked.cores_max, 4U);
  EXPECT_TRUE(asked.scopes.has(rpc::Scope::read) && asked.scopes.has(rpc::Scope::operate));
  EXPECT_FALSE(asked.scopes.has(rpc::Scope::submit) || asked.scopes.has(rpc::Scope::manage));
}

TEST_F(TokenCommands, AFileOfATokenIsNewAndItsOwners) {
  TokenCreateOptions options{.name = "laptop", .output = file()};
  EXPECT_EQ(out([&] { return create_token(socket(), options); }), "");
  struct stat seen = {};
  ASSERT_EQ(::stat(file().c_str(), &seen), 0);
  EXPECT_EQ(seen.st_mode & 0777U, 0600U);
  std::string text;
  std::getline(std::ifstream(file()), text);
  EXPECT_EQ(text, handler_.asked_token.token);
  EXPECT_EQ(failure([&] { create_token(socket(), options); }), base::ExitCode::conflict);
  serving_.reset();
  options.output = folder_ / "other.token";
  EXPECT_EQ(failure([&] { create_token(socket(), options); }), base::ExitCode::no_server);
  EXPECT_FALSE(std::filesystem::exists(options.output));
}

// An empty user name, as from a script's unset variable, is refused.
TEST_F(TokenCommands, AUserIsOneThatThereIs) {
  for (const char* user : {"", " ", "no such user", "4294967295", "4294967296", "-1", "1.5"}) {
    TokenCreateOptions options{.name = "laptop", .user = user};
    EXPECT_NE(failure([&] { create_token(socket(), options); }), base::ExitCode::ok) << user;
    EXPECT_EQ(handler_.asked_token.token, "") << user;
  }
  TokenCreateOptions options{.name = "laptop", .user = "64002"};
  out([&] { return create_token(socket(), options); });
  EXPECT_EQ(handler_.asked_token.for_user, 64002U);
}

TEST_F(TokenCommands, TimesAreReadAsPeopleWriteThem) {
  EXPECT_EQ(validity_s_of("never"), 0);
  EXPECT_EQ(validity_s_of("90d"), 90 * 86400.0);
  EXPECT_EQ(validity_s_of("1.5h"), 5400.0);
  EXPECT_EQ(validity_s_of("3650d"), 3650 * 86400.0);
  for (const char* wrong : {"", "d", "0d", "-1d", "3651d", "soon", "1e9d", "nan"})
    EXPECT_EQ(failure([&] { validity_s_of(wrong); }), base::ExitCode::usage) << wrong;
}

TEST_F(TokenCommands, TheListIsOfValidOnes) {
  handler_.tokens = {{.id = "0123456789", .name = "\x1b[2J laptop", .expires_s = 0},
                     {.id = "1123456789", .name = "old", .expires_s = 1, .has_expired = true},
                     {.id = "2123456789", .name = "lost", .revoked_s = 1}};
  const std::string text = out([&] { return list_tokens(socket(), false, false); });
  EXPECT_NE(text.find("0123456789"), std::string::npos);
  EXPECT_EQ(text.find('\x1b'), std::string::npos);
  EXPECT_EQ(text.find("1123456789"), std::string::npos);
  const auto json = json::Value::parse(out([&] { return list_tokens(socket(), true, true); }));
  ASSERT_EQ(json.size(), 3U);
  EXPECT_EQ(json[0]["state"], "valid");
  EXPECT_TRUE(json[0]["expires"].is_null());
  EXPECT_EQ(json[1]["state"], "expired");
  EXPECT_EQ(json[2]["state"], "revoked");
}

TEST_F(TokenCommands, OnlyIdsAreRevoked) {
  handler_.tokens = {{.id = "0123456789", .name = "laptop"}};
  EXPECT_NE(
      out([&] { return revoke_tokens(socket(), {.ids = {"0123456789"}}); }).find("is revoked"),
      std::string::npos);
  // If a user gives a whole token by mistake, the command neither sends nor shows it.
  const std::string token = access::text_of(access::draw_token());
  EXPECT_EQ(failure([&] { revoke_tokens(socket(), {.ids = {token}}); }), base::ExitCode::usage);
  handler_.tokens.push_back({.id = "1123456789", .name = "other"});
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(revoke_tokens(socket(), {.ids = {"0123456789", "2123456789", "1123456789"}}),
            static_cast<int>(base::ExitCode::usage));
  const std::string done = ::testing::internal::GetCapturedStdout();
  EXPECT_NE(done.find("0123456789"), std::string::npos);
  EXPECT_NE(done.find("1123456789"), std::string::npos);
  EXPECT_NE(::testing::internal::GetCapturedStderr().find("2123456789: There is no such token"),
            std::string::npos);
}

TEST_F(TokenCommands, KnownServersAreTheirOwnersAlone) {
  ::setenv("XDG_CONFIG_HOME", folder_.c_str(), 1);
  const rpc::RemoteService service{
      .address = {.host = "render.example.org"}, .token = "t", .certificate = "c", .own_name = "n"};
  const std::string path = service_client::remember(service);
  const auto place = service_client::place_of("render.example.org");
  ASSERT_TRUE(std::holds_alternative<rpc::RemoteService>(place));
  EXPECT_EQ(std::get<rpc::RemoteService>(place).token, "t");
  EXPECT_EQ(std::get<rpc::RemoteService>(place).certificate, "c");
  EXPECT_EQ(std::get<rpc::RemoteService>(place).own_name, "n");
  ::chmod(path.c_str(), 0640);
  EXPECT_EQ(failure([] { service_client::place_of("render.example.org"); }),
            base::ExitCode::environment);
  ::chmod(path.c_str(), 0600);
  std::ofstream(path) << "{";
  EXPECT_EQ(failure([] { service_client::place_of("render.example.org"); }),
            base::ExitCode::environment);
  EXPECT_TRUE(service_client::forget(service.address));
  EXPECT_FALSE(service_client::forget(service.address));
  EXPECT_EQ(failure([] { service_client::place_of("render.example.org"); }), base::ExitCode::usage);
  EXPECT_EQ(failure([] { service_client::place_of("../x"); }), base::ExitCode::usage);
  EXPECT_EQ(std::get<std::string>(service_client::place_of("/run/socket")), "/run/socket");
  ::unsetenv("XDG_CONFIG_HOME");
}

}  // namespace
}  // namespace sleight::cli
