// Goal: callers see and do only what their rights allow. A submission is accepted once, and whole
// or not at all. Method: send calls to the handler. The event loop, the store and the state machine
// are real. The keeper and `sleight` don't exist, so jobs stay queued. The callers' user ids need
// not exist on this machine.
#include "service/daemon/calls.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <future>
#include <memory>
#include <optional>

#include "common/access/token_text.h"
#include "tests/support/facts.h"
#include "tests/unit/common/request/toy_world.h"

namespace sleight::daemon {
namespace {

using ::testing::HasSubstr;

constexpr const char* k_request = "[world]\nname = 'toy'\n[stop]\nscans = 10\n";
const rpc::Caller k_ada{.user = 4001};
const rpc::Caller k_bob{.user = 4002};

class CallsTest : public ::testing::Test {
 protected:
  CallsTest() {
    state_ = std::filesystem::temp_directory_path() /
             ("calls-" + std::to_string(::getpid()) + "-" +
              ::testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(state_);
    begin();
  }
  ~CallsTest() override {
    end();
    std::filesystem::remove_all(state_);
  }

  void begin() {
    loop_ = std::make_unique<rpc::Loop>();
    RunnerOptions options{.state = state_, .cores = 2, .memory_bytes = std::uint64_t{8} << 30U};
    options.jobs.limits.jobs = 5;
    options.programs = {.keeper = "/no/keeper", .sleight = "/no/sleight"};
    runner_ = std::make_unique<JobRunner>(*loop_, options, [](jobs::JobId) {});
    tokens_ = std::make_unique<Tokens>(files_, state_ / "tokens.json", [] { return 1e9; });
    calls_ = std::make_unique<Calls>(
        *loop_, *runner_, *tokens_, ServerFacts{},
        [this](const std::string& text, const std::string& name) {
          return request::read_request(text, name, worlds_);
        },
        [this] { loop_->stop(); });
    runner_->begin();
  }
  void end() {
    calls_.reset();
    runner_.reset();
    loop_.reset();
  }

  /// Runs the loop until the call is answered.
  template <class T, class Call>
  base::Result<T, rpc::Refusal> answer(const Call& call) {
    std::optional<base::Result<T, rpc::Refusal>> answered;
    call(rpc::Reply<T>([&](typename rpc::Reply<T>::Answer answer) {
      answered = std::move(answer);
      loop_->stop();
    }));
    while (!answered)  // an answer that comes at once stops the next run
      loop_->run();
    return *std::move(answered);
  }

  static rpc::Submission submission(const std::string& key, int jobs,
                                    const std::string& text = k_request) {
    rpc::Submission made{.key = key};
    for (int i = 0; i < jobs; ++i)
      made.jobs.push_back({.name = "job " + std::to_string(i), .request = text});
    return made;
  }
  base::Result<rpc::Submitted, rpc::Refusal> submit(const rpc::Caller& caller,
                                                    const rpc::Submission& what) {
    return answer<rpc::Submitted>(
        [&](rpc::Reply<rpc::Submitted> reply) { calls_->submit(caller, what, std::move(reply)); });
  }
  rpc::JobPage list(const rpc::Caller& caller, const rpc::ListAsk& ask = {}) {
    return answer<rpc::JobPage>(
               [&](rpc::Reply<rpc::JobPage> reply) { calls_->list(caller, ask, std::move(reply)); })
        .value();
  }
  /// If the kind is `extend`, `scans` is the new number of scans.
  base::Result<std::vector<rpc::Touched>, rpc::Refusal> change(const rpc::Caller& caller,
                                                               rpc::JobId job, rpc::ChangeKind kind,
                                                               double scans = 0) {
    const rpc::ChangeAsk ask{.target = rpc::Target::of(job),
                             .kind = kind,
                             .extension = {.by = rpc::ExtendBy::scans, .to = scans}};
    return answer<std::vector<rpc::Touched>>(
        [&](auto reply) { calls_->change(caller, ask, std::move(reply)); });
  }

  std::filesystem::path state_;
  std::array<request::WorldBinding, 1> worlds_{request::toy::binding()};
  std::unique_ptr<rpc::Loop> loop_;
  std::unique_ptr<JobRunner> runner_;
  base::PosixFileSystem files_;
  std::unique_ptr<Tokens> tokens_;
  std::unique_ptr<Calls> calls_;
};

TEST_F(CallsTest, ASubmissionIsTakenOnce) {
  const auto first = submit(k_ada, submission("key", 1));
  ASSERT_TRUE(first.ok());
  const auto again = submit(k_ada, submission("key", 1));
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(again.value().jobs, first.value().jobs);
  EXPECT_TRUE(again.value().was_known);
  // Two users may use the same key. If a user sends a known key with other content, the submission
  // is refused.
  EXPECT_NE(submit(k_bob, submission("key", 1)).value().jobs, first.value().jobs);
  const auto other =
      submit(k_ada, submission("key", 1, "[world]\nname = 'toy'\n[stop]\nscans = 11\n"));
  ASSERT_FALSE(other.ok());
  EXPECT_EQ(other.error().kind, rpc::RefusalKind::conflict);
}

TEST_F(CallsTest, ASubmissionIsKnownAfterARestart) {
  const auto group = submit(k_ada, submission("key", 3));
  ASSERT_TRUE(group.ok());
  ASSERT_TRUE(group.value().group.has_value());
  end();
  begin();
  const auto again = submit(k_ada, submission("key", 3));
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(again.value().jobs, group.value().jobs);
  EXPECT_EQ(again.value().group, group.value().group);
  EXPECT_TRUE(again.value().was_known);
}

TEST_F(CallsTest, AGroupIsTakenWholeOrNotAtAll) {
  ASSERT_TRUE(submit(k_ada, submission("a", 3)).ok());
  const auto too_many = submit(k_ada, submission("b", 3));  // the limit is five per user
  ASSERT_FALSE(too_many.ok());
  EXPECT_EQ(too_many.error().kind, rpc::RefusalKind::limit);
  EXPECT_EQ(list(k_ada).total, 3U);
  ASSERT_TRUE(submit(k_ada, submission("c", 2)).ok());
  EXPECT_EQ(list(k_ada).total, 5U);
}

TEST_F(CallsTest, BadRequestsNameTheirPlaces) {
  const auto refused = submit(k_ada, submission("key", 1, "[world]\nname = 'toy'\nheigth_m = 3\n"));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().kind, rpc::RefusalKind::bad_request);
  ASSERT_FALSE(refused.error().diagnostics.empty());
  EXPECT_EQ(refused.error().diagnostics.front().file, "job 0");
  EXPECT_EQ(refused.error().diagnostics.front().place.line, 3U);
  EXPECT_EQ(list(k_ada).total, 0U);
}

// To a user, other users' jobs seem not to exist.
TEST_F(CallsTest, UsersSeeTheirOwn) {
  const rpc::JobId job = submit(k_ada, submission("key", 1)).value().jobs.front();
  EXPECT_EQ(list(k_bob).total, 0U);
  EXPECT_EQ(list({.user = ::geteuid()}).total, 1U);
  const auto status = answer<rpc::JobView>(
      [&](rpc::Reply<rpc::JobView> reply) { calls_->status(k_bob, job, std::move(reply)); });
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().kind, rpc::RefusalKind::not_found);
  const auto never = answer<rpc::JobView>([&](rpc::Reply<rpc::JobView> reply) {
    calls_->status(k_bob, rpc::JobId{99}, std::move(reply));
  });
  EXPECT_EQ(never.error().sentence, "There is no job 99.");
  EXPECT_FALSE(change(k_bob, job, rpc::ChangeKind::cancel).ok());
  EXPECT_FALSE(calls_->events_after(k_bob, {.job = job}, 10).ok());
  EXPECT_TRUE(calls_->events_after(k_ada, {.job = job}, 10).ok());
  for (const auto& touch : {&Calls::drain, &Calls::stop}) {
    const auto refused = answer<rpc::Nothing>(
        [&](rpc::Reply<rpc::Nothing> reply) { (*calls_.*touch)(k_bob, std::move(reply)); });
    EXPECT_EQ(refused.error().kind, rpc::RefusalKind::not_allowed);
  }
}

TEST_F(CallsTest, ListsHavePagesAndFilters) {
  ASSERT_TRUE(submit(k_ada, submission("key", 5)).ok());
  rpc::ListAsk ask{.count = 2};
  std::vector<std::uint64_t> ids;
  do {
    const rpc::JobPage page = list(k_ada, ask);
    EXPECT_EQ(page.total, 5U);
    for (const rpc::JobView& job : page.jobs)
      ids.push_back(job.id.value);
    ask.cursor = page.cursor;
  } while (!ask.cursor.empty());
  EXPECT_EQ(ids, (std::vector<std::uint64_t>{5, 4, 3, 2, 1}));
  EXPECT_EQ(list(k_ada, {.name_part = "job 3"}).total, 1U);
  EXPECT_EQ(list(k_ada, {.states = {rpc::JobState::done}}).total, 0U);
  const auto nonsense = answer<rpc::JobPage>([&](rpc::Reply<rpc::JobPage> reply) {
    calls_->list(k_ada, {.cursor = "five"}, std::move(reply));
  });
  EXPECT_EQ(nonsense.error().kind, rpc::RefusalKind::bad_request);
}

TEST_F(CallsTest, CancelExtendAndDelete) {
  const rpc::JobId job = submit(k_ada, submission("key", 1)).value().jobs.front();
  const auto cancelled = change(k_ada, job, rpc::ChangeKind::cancel);
  EXPECT_EQ(cancelled.value().front().state, rpc::JobState::cancelled);
  const auto shorter = change(k_ada, job, rpc::ChangeKind::extend, 10);
  ASSERT_FALSE(shorter.ok());
  EXPECT_THAT(shorter.error().sentence, HasSubstr("already"));
  const auto longer = change(k_ada, job, rpc::ChangeKind::extend, 20);
  ASSERT_TRUE(longer.ok());
  EXPECT_FALSE(rpc::is_settled(longer.value().front().state));
  EXPECT_THAT(runner_->reader().request(jobs::JobId{job.value}, 2)->text, HasSubstr("scans = 20"));
  ASSERT_TRUE(change(k_ada, job, rpc::ChangeKind::cancel).ok());
  ASSERT_TRUE(change(k_ada, job, rpc::ChangeKind::erase).ok());
  const auto gone = answer<rpc::JobView>(
      [&](rpc::Reply<rpc::JobView> reply) { calls_->status(k_ada, job, std::move(reply)); });
  EXPECT_EQ(gone.error().kind, rpc::RefusalKind::gone);
}

// A token limits its jobs and the cores of a job. These limits apply in addition to the user's
// limits.
TEST_F(CallsTest, ATokensLimits) {
  rpc::Caller caller{.user = 4001, .token_id = "0123456789", .token_jobs_max = 2};
  ASSERT_TRUE(submit(k_ada, submission("own", 2)).ok());
  ASSERT_TRUE(submit(caller, submission("a", 1)).ok());
  const auto too_many = submit(caller, submission("b", 2));
  ASSERT_FALSE(too_many.ok());
  EXPECT_EQ(too_many.error().kind, rpc::RefusalKind::limit);
  EXPECT_THAT(too_many.error().sentence, tests::HasFacts("at most 2|1|2 more"));
  EXPECT_TRUE(submit(caller, submission("c", 1)).ok());
  EXPECT_FALSE(submit(caller, submission("d", 1)).ok());
  // The limits hold after a restart too.
  end();
  begin();
  EXPECT_FALSE(submit(caller, submission("e", 1)).ok());
  EXPECT_TRUE(submit(k_ada, submission("f", 1)).ok());
}

// A token limits how many of its jobs may be unfinished. The limit applies both to submitted jobs
// and to ended jobs that are resumed.
TEST_F(CallsTest, ATokenBringsBackItsOwnWithinItsLimits) {
  const rpc::Caller caller{.user = 4001, .token_id = "0123456789", .token_jobs_max = 1};
  const auto own = submit(k_ada, submission("own", 1));
  const auto first = submit(caller, submission("a", 1));
  ASSERT_TRUE(own.ok() && first.ok());
  const auto cancel = [&](rpc::JobId job) {
    ASSERT_TRUE(change(k_ada, job, rpc::ChangeKind::cancel).ok());
  };
  const auto resume = [&](const rpc::Caller& by, rpc::JobId job) {
    return change(by, job, rpc::ChangeKind::resume);
  };
  const auto extend = [&](const rpc::Caller& by, rpc::JobId job) {
    return change(by, job, rpc::ChangeKind::extend, 20);
  };
  const rpc::JobId one = first.value().jobs.front();
  cancel(one);
  const auto second = submit(caller, submission("b", 1));
  ASSERT_TRUE(second.ok());
  EXPECT_EQ(resume(caller, one).error().kind, rpc::RefusalKind::limit);
  EXPECT_EQ(extend(caller, one).error().kind, rpc::RefusalKind::limit);
  // The job hasn't ended, so the limit already counts it, and it can be extended.
  EXPECT_TRUE(extend(caller, second.value().jobs.front()).ok());
  // A limited token can't resume a job that was submitted without it.
  const rpc::JobId others = own.value().jobs.front();
  EXPECT_THAT(extend(caller, others).error().sentence, HasSubstr("was not submitted with it"));
  cancel(others);
  EXPECT_EQ(resume(caller, others).error().kind, rpc::RefusalKind::limit);
  // The user's unlimited token can resume the job. Once another job is cancelled, the limited token
  // has room for its own job again.
  EXPECT_TRUE(resume({.user = 4001, .token_id = "1123456789"}, others).ok());
  cancel(second.value().jobs.front());
  EXPECT_TRUE(resume(caller, one).ok());
}

TEST_F(CallsTest, ARevocationThatCantBeSavedSaysSo) {
  const std::string text = access::text_of(access::draw_token());
  rpc::TokenAsk ask{.token = text, .name = "a"};
  ask.scopes.add(rpc::Scope::read);
  ASSERT_TRUE(answer<rpc::TokenView>([&](auto reply) {
                calls_->create_token(k_ada, ask, std::move(reply));
              }).ok());
  std::filesystem::create_directory(state_ / "tokens.json.new");
  const auto refused = answer<rpc::TokenView>([&](auto reply) {
    calls_->revoke_token(k_ada, access::token_of(text)->id, std::move(reply));
  });
  ASSERT_FALSE(refused.ok());
  EXPECT_THAT(refused.error().sentence, HasSubstr("valid again after a restart"));
}

TEST_F(CallsTest, ATokensCores) {
  const rpc::Caller caller{.user = 4001, .token_id = "0123456789", .token_cores_max = 2};
  rpc::Submission wide = submission("a", 1);
  wide.jobs[0].cores = 3;
  EXPECT_EQ(submit(caller, wide).error().kind, rpc::RefusalKind::limit);
  rpc::Submission ranks = submission("b", 1);
  ranks.jobs[0].ranks = 3;
  EXPECT_EQ(submit(caller, ranks).error().kind, rpc::RefusalKind::limit);
  const auto unwished = submit(caller, submission("c", 1));
  ASSERT_TRUE(unwished.ok());
  EXPECT_EQ(list(caller).jobs.at(0).cores_wanted, 2U);
}

// If a token of the daemon's own user lacks the scope `operate`, it has an ordinary user's rights.
TEST_F(CallsTest, AnOperatorsTokenSeesLessWithoutOperate) {
  ASSERT_TRUE(submit(k_ada, submission("a", 1)).ok());
  rpc::Caller own{.user = ::geteuid(), .token_id = "0123456789"};
  EXPECT_EQ(list(own).total, 1U);
  own.scopes = {};
  own.scopes.add(rpc::Scope::read);
  EXPECT_EQ(list(own).total, 0U);
}

TEST_F(CallsTest, OptionsComeBackWithTheJob) {
  rpc::Submission asked = submission("a", 1);
  asked.jobs[0].options = {{.name = "partition", .value = "long"}};
  const auto made = submit(k_ada, asked);
  ASSERT_TRUE(made.ok());
  rpc::Submission other = asked;
  other.jobs[0].options[0].value = "short";
  EXPECT_EQ(submit(k_ada, other).error().kind, rpc::RefusalKind::conflict);
  end();
  begin();
  const auto stored = runner_->reader().request(jobs::JobId{made.value().jobs.front().value}, 1);
  ASSERT_TRUE(stored.has_value());
  EXPECT_EQ(stored->options.at("partition"), "long");
}

// Goal: a limited number of a user's fetches may wait, and they don't block other users' fetches.
// Method: the thread that makes archives is busy. Start more fetches than the limit allows.
TEST_F(CallsTest, AUsersFetchesThatWaitAreBounded) {
  const auto of_ada = submit(k_ada, submission("key", 1)).value().jobs.front();
  const auto of_bob = submit(k_bob, submission("key", 1)).value().jobs.front();
  std::promise<void> go_on;
  runner_->maker().run([waited = go_on.get_future().share()] { waited.wait(); });
  std::size_t answered = 0;
  std::optional<rpc::RefusalKind> last;
  const auto fetch = [&](const rpc::Caller& caller, rpc::JobId job) {
    last.reset();
    calls_->fetch(caller, {.job = job, .kind = rpc::FetchKind::so_far},
                  rpc::Reply<rpc::Fetched>([&](const auto& answer) {
                    ++answered;
                    if (!answer.ok()) last = answer.error().kind;
                  }));
  };
  for (std::size_t i = 0; i < k_fetches_of_user_max; ++i)
    fetch(k_ada, of_ada);
  EXPECT_EQ(answered, 0U);
  fetch(k_ada, of_ada);
  EXPECT_EQ(last, rpc::RefusalKind::busy);
  fetch(k_bob, of_bob);
  EXPECT_EQ(answered, 1U);
  const auto await = [&](std::size_t count) {
    while (answered < count) {
      const auto stopping = loop_->call_later(0.01, [this] { loop_->stop(); });
      loop_->run();
    }
  };
  // Finished fetches make room for new ones.
  go_on.set_value();
  await(k_fetches_of_user_max + 2);
  fetch(k_ada, of_ada);
  await(k_fetches_of_user_max + 3);
  EXPECT_NE(last, rpc::RefusalKind::busy);
}

}  // namespace
}  // namespace sleight::daemon
