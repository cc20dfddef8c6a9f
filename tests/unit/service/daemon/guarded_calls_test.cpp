// Goal: a token's scopes decide what a session may do, nobody makes tokens by one, and the audit
// log says who did what, whole, bounded, and whatever strangers try. Method: each call by each
// single scope, with a handler that notes what reaches it; the log's lines are read back.
#include "service/daemon/guarded_calls.h"
#include "common/json/value.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <set>

#include "common/access/token_text.h"
#include "common/base/clock.h"
#include "common/logging/log.h"
#include "tests/unit/common/rpc/fake_service.h"

namespace sleight::daemon {
namespace {

using rpc::Scope;
using ::testing::HasSubstr;

class GuardedCallsTest : public ::testing::Test {
 protected:
  GuardedCallsTest()
      : folder_(std::filesystem::temp_directory_path() /
                ("guarded-" + std::to_string(::getpid()) + "-" +
                 ::testing::UnitTest::GetInstance()->current_test_info()->name())) {
    std::filesystem::create_directories(folder_);
    inner_.jobs[1].view = {.id = {1}};
  }
  ~GuardedCallsTest() override { std::filesystem::remove_all(folder_); }

  std::vector<json::Value> lines(const char* name = "audit.log") const {
    std::vector<json::Value> read;
    std::ifstream file(folder_ / name);
    for (std::string line; std::getline(file, line);)
      read.push_back(json::Value::parse(line));
    return read;
  }
  static rpc::Caller with(Scope scope) {
    rpc::Caller caller{.user = 4001, .address = "192.0.2.7:5", .token_id = "0123456789"};
    caller.scopes = {};
    caller.scopes.add(scope);
    return caller;
  }
  /// The kind of refusal that a call gets; none: it is let through.
  template <class T, class Call>
  static std::optional<rpc::RefusalKind> refusal(const Call& call) {
    std::optional<rpc::RefusalKind> kind;
    call(rpc::Reply<T>([&](base::Result<T, rpc::Refusal> answer) {
      if (!answer.ok()) kind = answer.error().kind;
    }));
    return kind;
  }
  /// Names of the calls that this caller may make.
  std::set<std::string> allowed(const rpc::Caller& caller) {
    std::set<std::string> names;
    const auto note = [&](std::string_view name, std::optional<rpc::RefusalKind> kind) {
      if (kind != rpc::RefusalKind::not_allowed) names.emplace(name);
    };
    note("submit", refusal<rpc::Submitted>([&](auto reply) {
           calls_.submit(caller, {.key = "k", .jobs = {{}}}, std::move(reply));
         }));
    note("list",
         refusal<rpc::JobPage>([&](auto reply) { calls_.list(caller, {}, std::move(reply)); }));
    note("status",
         refusal<rpc::JobView>([&](auto reply) { calls_.status(caller, {1}, std::move(reply)); }));
    const auto batch = calls_.events_after(caller, {.job = {1}}, 10);
    note("watch", batch.ok() ? std::nullopt : std::optional(batch.error().kind));
    note("logs", refusal<rpc::LogPiece>(
                     [&](auto reply) { calls_.logs(caller, {.job = {1}}, std::move(reply)); }));
    for (std::size_t kind = 1; kind < rpc::k_change_kinds; ++kind) {
      const rpc::ChangeAsk ask{.target = rpc::Target::of(rpc::JobId{1}),
                               .kind = static_cast<rpc::ChangeKind>(kind)};
      note(rpc::name_of(ask.kind), refusal<std::vector<rpc::Touched>>([&](auto reply) {
             calls_.change(caller, ask, std::move(reply));
           }));
    }
    note("fetch", refusal<rpc::Fetched>(
                      [&](auto reply) { calls_.fetch(caller, {.job = {1}}, std::move(reply)); }));
    note("info",
         refusal<rpc::ServerView>([&](auto reply) { calls_.info(caller, std::move(reply)); }));
    note("drain",
         refusal<rpc::Nothing>([&](auto reply) { calls_.drain(caller, std::move(reply)); }));
    note("stop", refusal<rpc::Nothing>([&](auto reply) { calls_.stop(caller, std::move(reply)); }));
    note("create_token", refusal<rpc::TokenView>([&](auto reply) {
           calls_.create_token(caller, {.token = token_}, std::move(reply));
         }));
    note("list_tokens", refusal<std::vector<rpc::TokenView>>(
                            [&](auto reply) { calls_.list_tokens(caller, std::move(reply)); }));
    note("revoke_token", refusal<rpc::TokenView>([&](auto reply) {
           calls_.revoke_token(caller, "0123456789", std::move(reply));
         }));
    return names;
  }

  std::filesystem::path folder_;
  base::ManualClock clock_;
  rpc::testing::FakeService inner_;
  AuditLog audit_{folder_, clock_, 4000};
  GuardedCalls calls_{inner_, audit_};
  std::string token_ = access::text_of(access::draw_token());
};

TEST_F(GuardedCallsTest, EachScopeAllowsItsCallsAlone) {
  const std::map<Scope, std::set<std::string>> expected = {
      {Scope::read, {"list", "status", "watch", "logs", "fetch", "info"}},
      {Scope::submit, {"submit"}},
      {Scope::manage,
       {"cancel", "hold", "resume", "extend", "erase", "pin", "unpin", "set_priority"}},
      {Scope::operate, {"drain", "stop"}}};
  for (const auto& [scope, calls] : expected)
    EXPECT_EQ(allowed(with(scope)), calls) << rpc::name_of(scope);
}

TEST_F(GuardedCallsTest, AUserOfThisMachineMayDoAll) {
  EXPECT_EQ(allowed({.user = 4001, .pid = 7}).size(), 20U);
}

TEST_F(GuardedCallsTest, TheLogSaysWhoDidWhat) {
  refusal<rpc::Submitted>([&](auto reply) {
    calls_.submit({.user = 4001, .pid = 7}, {.key = "k", .jobs = {{}, {}}}, std::move(reply));
  });
  refusal<std::vector<rpc::Touched>>([&](auto reply) {
    calls_.change(with(Scope::read),
                  {.target = rpc::Target::of(rpc::GroupId{5}), .kind = rpc::ChangeKind::cancel},
                  std::move(reply));
  });
  const auto read = lines();
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read[0]["call"], "submit");
  EXPECT_EQ(read[0]["from"], "process 7");
  EXPECT_EQ(read[0]["of"], "2 jobs");
  EXPECT_EQ(read[0]["outcome"], "done");
  EXPECT_FALSE(read[0]["made"].get<std::string>().empty());
  EXPECT_EQ(read[1]["call"], "cancel");
  EXPECT_EQ(read[1]["user"], 4001);
  EXPECT_EQ(read[1]["from"], "192.0.2.7:5");
  EXPECT_EQ(read[1]["token"], "0123456789");
  EXPECT_EQ(read[1]["of"], "g5");
  EXPECT_THAT(read[1]["outcome"].get<std::string>(), HasSubstr("not_allowed"));
}

// Strangers are as many lines as there are seconds, and each is counted.
TEST_F(GuardedCallsTest, StrangersCantFillTheLog) {
  for (int i = 0; i < 1000; ++i) {
    audit_.note_stranger("203.0.113.9:1");
    clock_.advance(0.01);
  }
  clock_.advance(1);
  audit_.flush();
  std::uint64_t times = 0;
  for (const auto& line : lines())
    times += line.value("times", 1);
  EXPECT_LE(lines().size(), 12U);
  EXPECT_EQ(times, 1000U);
}

TEST_F(GuardedCallsTest, TheLogIsBounded) {
  for (int i = 0; i < 200; ++i)
    audit_.note({.user = 4001, .pid = i}, {.call = "submit", .outcome = "done"});
  EXPECT_LE(std::filesystem::file_size(folder_ / "audit.log"), 4000U);
  EXPECT_LE(std::filesystem::file_size(folder_ / "audit.old.log"), 4000U);
  EXPECT_EQ(lines().back()["from"], "process 199");
  EXPECT_FALSE(lines("audit.old.log").empty());
}

// What one of them repeats has no lines any more, and is counted: what others did stays.
TEST_F(GuardedCallsTest, NobodyPushesOutWhatHappenedBefore) {
  AuditLog audit(folder_, clock_);
  audit.note({.user = 4002, .pid = 1}, {.call = "create_token", .outcome = "done"});
  constexpr std::uint64_t k_pins = 300'000;
  for (std::uint64_t i = 0; i < k_pins; ++i) {
    audit.note(with(Scope::manage), {.call = "pin", .of = "14", .outcome = "done"});
    clock_.advance(0.0002);
  }
  audit.note(with(Scope::manage), {.call = "cancel", .of = "15", .outcome = "done"});
  clock_.advance(60);
  audit.flush();
  std::uint64_t pins = 0;
  std::uint64_t others = 0;
  for (const auto& line : lines()) {
    if (line["call"] == "pin") pins += line.value("more", 1);
    if (line["call"] != "pin") ++others;
  }
  EXPECT_EQ(pins, k_pins);
  EXPECT_EQ(others, 2U);
  EXPECT_LE(lines().size(), 1020U);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "audit.old.log"));
  // After some time it has lines again.
  clock_.advance(100);
  audit.note(with(Scope::manage), {.call = "pin", .of = "16", .outcome = "done"});
  EXPECT_EQ(lines().back()["of"], "16");
}

// Names are other people's: nothing in them breaks a line or a reader.
TEST_F(GuardedCallsTest, OddTextsStayInTheirLine) {
  audit_.note({.user = 1, .pid = 1},
              {.call = "submit", .of = "a\n{\"call\":\"stop\"}\x1b[2J\xff\xc3", .outcome = "done"});
  ASSERT_EQ(lines().size(), 1U);
  EXPECT_EQ(lines()[0]["call"], "submit");
}

// What stands in its place stops nobody, and is told once.
TEST_F(GuardedCallsTest, AFolderAPipeOrALinkInItsPlace) {
  const auto place = folder_ / "audit.log";
  for (const int kind : {0, 1, 2}) {
    if (kind == 0) std::filesystem::create_directory(place);
    if (kind == 1) {
      ASSERT_EQ(::mkfifo(place.c_str(), 0600), 0);
    }
    if (kind == 2) std::filesystem::create_symlink(folder_ / "elsewhere", place);
    AuditLog audit(folder_, clock_);
    ::testing::internal::CaptureStderr();
    logging::log_to_stderr("test", false);
    audit.note({.user = 1}, {.call = "submit", .outcome = "done"});
    audit.note({.user = 1}, {.call = "submit", .outcome = "done"});
    const std::string said = ::testing::internal::GetCapturedStderr();
    EXPECT_THAT(said, HasSubstr("can't be written")) << kind;
    EXPECT_EQ(said.find("can't be written"), said.rfind("can't be written")) << kind;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "elsewhere"));
    std::filesystem::remove(place);
    audit.note({.user = 1}, {.call = "cancel", .outcome = "done"});
    EXPECT_EQ(lines().front()["times"], 2);
    std::filesystem::remove(place);
  }
}

// A daemon that ends drops the calls before those who still owe an answer to one.
TEST_F(GuardedCallsTest, AReplyThatOutlivesTheCallsIsNoted) {
  inner_.keeps_fetches = true;
  bool is_answered = false;
  std::make_unique<GuardedCalls>(inner_, audit_)
      ->fetch({.user = 1, .pid = 1}, {.job = {1}},
              rpc::Reply<rpc::Fetched>([&](auto) { is_answered = true; }));
  ASSERT_TRUE(lines().empty());
  inner_.kept_fetches.clear();
  EXPECT_TRUE(is_answered);
  ASSERT_EQ(lines().size(), 1U);
  EXPECT_EQ(lines()[0]["call"], "fetch");
  EXPECT_THAT(lines()[0]["outcome"].get<std::string>(), HasSubstr("without an answer"));
}

}  // namespace
}  // namespace sleight::daemon
