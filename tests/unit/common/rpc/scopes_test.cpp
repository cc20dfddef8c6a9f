// Goal: a token's scopes determine which calls a client may make, and no token can create tokens.
// The audit records actions and refusals. Method: make each call over the Unix socket, and with
// tokens that have one scope each.
#include <unistd.h>

#include <map>
#include <mutex>
#include <set>

#include "common/access/certificates.h"
#include "common/access/token_text.h"
#include "common/rpc/client.h"
#include "tests/support/facts.h"
#include "tests/unit/common/rpc/fake_service.h"

namespace sleight::rpc {
namespace {

/// Accepts any token and gives it the scopes that the test chose.
class OneToken final : public Authority {
 public:
  base::Result<Caller, Refusal> login(const std::string&, const std::string& address) override {
    return Caller{.user = 4001, .address = address, .token_id = "0123456789", .scopes = scopes};
  }
  bool lets_go_on(const Caller&) override { return true; }
  Scopes scopes{};
};

class RefusalSink final : public WatchSink {
 public:
  bool changed(JobId, const StateChange&) override { return false; }
  bool happened(const WatchedEvent&) override { return false; }
  bool refused(JobId, const Refusal& refusal) override {
    kind = refusal.kind;
    return true;
  }
  std::optional<RefusalKind> kind{};
};

class ScopesTest : public testing::SocketFolder {
 protected:
  ScopesTest() {
    service_.jobs[1].view = {.id = {1}};
    service_.add_file("ball.h5", "bytes");
    server_.on_loop([&](Server& server) {
      address_ = server.listen({.host = "127.0.0.1", .port = 0}, keypair_, authority_);
    });
  }
  RemoteService remote(Scope scope) {
    authority_.scopes = {};
    authority_.scopes.add(scope);
    return {.address = address_,
            .token = token_,
            .certificate = keypair_.certificate,
            .own_name = access::k_self_name};
  }

  std::set<std::string> allowed(Client& client) {
    std::set<std::string> names;
    const auto note = [&](std::string_view name, const std::function<void()>& call) {
      std::optional<RefusalKind> kind;
      try {
        call();
      } catch (const RefusedError& error) {
        kind = error.refusal().kind;
      }
      if (kind != RefusalKind::not_allowed) names.emplace(name);
    };
    note("submit", [&] { client.submit({.key = "k", .jobs = {{.name = "a"}}}); });
    note("list", [&] { client.list({}); });
    note("status", [&] { client.status({1}); });
    RefusalSink sink;
    client.watch({1}, 1, sink);
    if (sink.kind != RefusalKind::not_allowed) names.insert("watch");
    note("logs", [&] { client.logs({.job = {1}}); });
    for (std::size_t kind = 1; kind < k_change_kinds; ++kind) {
      const ChangeAsk ask{.target = Target::of(JobId{1}),
                          .kind = static_cast<ChangeKind>(kind),
                          .extension = {.by = ExtendBy::scans, .to = 9}};
      note(name_of(ask.kind), [&] { client.change(ask); });
    }
    note("fetch", [&] { client.fetch_file({.job = {1}}, path("ball.h5")); });
    note("info", [&] { client.info(); });
    note("drain", [&] { client.drain(); });
    note("stop", [&] { client.stop(); });
    Scopes scopes;
    scopes.add(Scope::read);
    note("create_token",
         [&] { client.create_token({.token = token_, .name = "t", .scopes = scopes}); });
    note("list_tokens", [&] { client.tokens(); });
    note("revoke_token", [&] { client.revoke_token("0123456789"); });
    return names;
  }
  std::map<std::string, AuditLine> heard() {
    const std::lock_guard lock(mutex_);
    return heard_;
  }

  std::mutex mutex_;
  std::map<std::string, AuditLine> heard_;
  std::vector<Caller> callers_;
  access::Keypair keypair_ = access::make_self_signed();
  std::string token_ = access::text_of(access::draw_token());
  OneToken authority_;
  testing::FakeService service_;
  access::ServerAddress address_;
  testing::ServerThread server_{
      socket(), service_, {}, [this](const Caller& caller, const AuditLine& line) {
        const std::lock_guard lock(mutex_);
        heard_[line.call] = line;
        callers_.push_back(caller);
      }};  // last, so destroyed first
};

const std::set<std::string> k_audited{"submit",       "cancel",      "hold",         "resume",
                                      "extend",       "erase",       "pin",          "unpin",
                                      "fetch",        "drain",       "set_priority", "stop",
                                      "create_token", "list_tokens", "revoke_token"};

TEST_F(ScopesTest, EachScopeAllowsItsCallsAlone) {
  const std::map<Scope, std::set<std::string>> expected = {
      {Scope::read, {"list", "status", "watch", "logs", "fetch", "info"}},
      {Scope::submit, {"submit"}},
      {Scope::manage,
       {"cancel", "hold", "resume", "extend", "erase", "pin", "unpin", "set_priority"}},
      {Scope::operate, {"drain", "stop"}}};
  for (const auto& [scope, calls] : expected) {
    Client client(remote(scope));
    EXPECT_EQ(allowed(client), calls) << name_of(scope);
  }
  // If a call changes something or returns files, it is audited, even if it is refused.
  std::set<std::string> told;
  for (const auto& [call, line] : heard())
    told.insert(call);
  EXPECT_EQ(told, k_audited);
  EXPECT_EQ(callers_.front().token_id, "0123456789");
  EXPECT_THAT(heard()["submit"].outcome, tests::LinesHaveFacts("not_allowed: |'submit'"));
  EXPECT_EQ(heard()["revoke_token"].of, "0123456789");
  EXPECT_TRUE(
      heard()["revoke_token"].outcome.starts_with("not_allowed: Tokens can only be managed"));
}

TEST_F(ScopesTest, AUserOfThisMachineMayDoAll) {
  Client client(socket());
  EXPECT_EQ(allowed(client).size(), 20U);
  EXPECT_EQ(callers_.front().user, ::getuid());
  EXPECT_EQ(callers_.front().pid, ::getpid());
  auto told = heard();
  EXPECT_EQ(told["submit"].of, "1 job");
  EXPECT_EQ(told["submit"].outcome, "done");
  EXPECT_EQ(told["submit"].made, "2");
  EXPECT_EQ(told["cancel"].of, "1");
  EXPECT_EQ(told["fetch"].of, "1");
  EXPECT_EQ(told["create_token"].of, "");
  EXPECT_EQ(told["create_token"].made,
            "token " + access::token_of(token_)->id + " of user " + std::to_string(::getuid()));
  client.submit({.key = "many", .jobs = std::vector<JobAsk>(25, JobAsk{.name = "a"})});
  client.change({.target = Target::of(GroupId{5}), .kind = ChangeKind::hold});
  told = heard();
  EXPECT_EQ(told["submit"].of, "25 jobs");
  EXPECT_EQ(told["submit"].made, "3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 ...");
  EXPECT_EQ(told["hold"].of, "g5");
}

// Goal: if a server ends before it answers a call, the call is audited. Method: destroy first the
// server, then the pending reply, as a daemon does when it ends.
TEST_F(ScopesTest, AReplyThatOutlivesTheServerIsTold) {
  Loop loop;
  testing::FakeService service;
  service.keeps_fetches = true;
  std::vector<AuditLine> lines;
  const ServerOptions options{
      .audit = [&](const Caller&, const AuditLine& line) { lines.push_back(line); }};
  auto server = std::make_unique<Server>(loop, path("other"), service, options);
  std::thread asks([&] {
    Client client(path("other"), {.call_s_max = 5, .away_s_max = 0.1});
    EXPECT_THROW(client.fetch_file({.job = {1}}, path("none.h5")), NoServer);
  });
  const auto look = loop.call_every(0.001, [&] {
    if (!service.kept_fetches.empty()) loop.stop();
  });
  loop.run();
  server.reset();
  ASSERT_TRUE(lines.empty());
  service.kept_fetches.clear();
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].call, "fetch");
  EXPECT_NE(lines[0].outcome.find("did not answer"), std::string::npos);
  asks.join();
}

}  // namespace
}  // namespace sleight::rpc
