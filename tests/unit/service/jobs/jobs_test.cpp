// Goal: each input of the jobs' state machine has the right effects. Method: send inputs to the
// state machine. The computer has four cores.
#include "service/jobs/jobs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace sleight::jobs {
namespace {

constexpr UserId k_ann{1};
constexpr UserId k_bob{2};

/// The jobs' state machine with a simulated store and a simulated clock.
class Bench {
 public:
  explicit Bench(const Options& options = {}) : options_(options) { begin(); }

  std::vector<Effect> step(const Input& input) {
    std::vector<Effect> effects = machine_->step(input);
    for (std::size_t i = 0; i < effects.size(); ++i) {
      const auto* save = std::get_if<Save>(&effects[i]);
      if (save == nullptr) continue;
      EXPECT_EQ(i, 0U) << "a save is its step's first effect";
      for (const Job& job : save->jobs)
        stored_[job.id] = job;
      for (const JobId id : save->erased)
        stored_.erase(id);
      for (const Usage& usage : save->usages)
        usages_[usage.user] = usage;
      clock_s_ = save->clock_s;
      next_id_ = save->next_id;
      changes_ += save->changes.size();
    }
    return effects;
  }
  std::vector<Effect> wait(double seconds) {
    now_s_ += seconds;
    return step(Tick{.now_s = now_s_, .wall = 1e9 + now_s_});
  }
  /// Kills the daemon and starts another.
  std::vector<Effect> begin() {
    Restored restored{.clock_s = clock_s_, .next_id = next_id_};
    for (const auto& [id, job] : stored_)
      restored.jobs.push_back(job);
    for (const auto& [user, usage] : usages_)
      restored.usages.push_back(usage);
    machine_ = std::make_unique<Jobs>(options_, restored);
    now_s_ = 0;
    wait(0);
    std::vector<Effect> effects = step(Began{});
    for (Effect& effect : step(room))
      effects.push_back(std::move(effect));
    return effects;
  }
  std::optional<Refusal> ask(JobId job, AskKind kind, UserId user = k_ann) {
    return answer_in(step(Ask{.user = user, .job = job, .kind = kind})).refusal;
  }
  Answer submit(const std::string& key, const std::string& content, UserId user = k_ann,
                const Wishes& wishes = {}) {
    return answer_in(
        step(Submit{.user = user, .client_key = key, .content = content, .wishes = wishes}));
  }
  JobId job(UserId user = k_ann, const Wishes& wishes = {}) {
    return submit({}, {}, user, wishes).job;
  }
  std::vector<Effect> see(JobId id, const decltype(Sight::seen)& seen) {
    return step(Sight{.job = id, .attempt = at(id).attempt, .seen = seen});
  }
  const Job& at(JobId id) const { return *machine_->find(id); }
  const Jobs& machine() const { return *machine_; }
  std::size_t changes() const { return changes_; }

  Room room{.cores = 4, .memory_bytes = 1000, .disk_free_bytes = 100, .disk_reserve_bytes = 10};

 private:
  static Answer answer_in(const std::vector<Effect>& effects) {
    for (const Effect& effect : effects) {
      if (const auto* answer = std::get_if<Answer>(&effect)) return *answer;
    }
    ADD_FAILURE() << "no answer";
    return {};
  }

  Options options_;
  std::unique_ptr<Jobs> machine_;
  double now_s_ = 0;
  std::map<JobId, Job> stored_;
  std::map<UserId, Usage> usages_;
  double clock_s_ = 0;
  std::uint64_t next_id_ = 1;
  std::size_t changes_ = 0;
};

template <class Kind>
std::vector<Kind> all_of(const std::vector<Effect>& effects) {
  std::vector<Kind> found;
  for (const Effect& effect : effects) {
    if (const auto* kind = std::get_if<Kind>(&effect)) found.push_back(*kind);
  }
  return found;
}

TEST(Jobs, StartInTheStepOfTheirSubmit) {
  Bench bench;
  const auto effects = bench.step(Submit{.token = 5, .user = k_ann});
  ASSERT_EQ(effects.size(), 3U);
  EXPECT_EQ(std::get<Save>(effects[0]).changes.size(), 2U);
  EXPECT_EQ(std::get<Answer>(effects[1]).token, 5U);
  EXPECT_EQ(std::get<Launch>(effects[2]).cores, 4U);
  EXPECT_EQ(std::get<Launch>(effects[2]).attempt, Attempt{1});
}

TEST(Jobs, AKeyMakesOneJob) {
  Bench bench;
  const Answer first = bench.submit("k", "content");
  EXPECT_TRUE(first.is_new);
  const Answer again = bench.submit("k", "content");
  EXPECT_EQ(again.job, first.job);
  EXPECT_FALSE(again.is_new);
  EXPECT_EQ(bench.submit("k", "other").refusal->kind, RefusalKind::key_in_use);
  EXPECT_NE(bench.submit("k", "content", k_bob).job, first.job) << "a key is a user's";
}

TEST(Jobs, AreNoOneElsesBusiness) {
  Bench bench;
  const JobId id = bench.job();
  EXPECT_EQ(bench.ask(id, AskKind::cancel, k_bob)->kind, RefusalKind::not_allowed);
  EXPECT_EQ(bench.ask(JobId{99}, AskKind::cancel)->kind, RefusalKind::not_found);
  EXPECT_EQ(bench.ask(id, AskKind::remove)->kind, RefusalKind::wrong_state);
}

TEST(Jobs, ThatNeverBeganAreLaunchedAgainAsTheSameAttempt) {
  Bench bench;
  const JobId id = bench.job();
  auto effects = bench.begin();
  ASSERT_EQ(all_of<Look>(effects).size(), 1U);
  EXPECT_TRUE(all_of<Launch>(effects).empty());
  effects = bench.see(id, NeverBegan{});
  ASSERT_EQ(all_of<Launch>(effects).size(), 1U);
  EXPECT_EQ(all_of<Launch>(effects)[0].attempt, Attempt{1});
  EXPECT_TRUE(bench.see(id, NeverBegan{}).empty()) << "an answer that comes twice";
}

TEST(Jobs, OfTwoLaunchesOneMayFailAndTheOtherBegin) {
  Bench bench;
  const JobId id = bench.job();
  bench.wait(5);  // without a report, the machine looks at the attempt
  ASSERT_EQ(all_of<Launch>(bench.see(id, NeverBegan{})).size(), 1U);
  bench.step(LaunchFailed{.job = id, .attempt = Attempt{1}, .is_backend_away = true});
  EXPECT_EQ(bench.at(id).state, State::starting) << "the first launch may be under way";
  bench.step(Launched{.job = id, .attempt = Attempt{1}});
  EXPECT_EQ(bench.at(id).state, State::running);
}

TEST(Jobs, ThatRunAreAdopted) {
  Bench bench;
  const JobId id = bench.job();
  bench.step(Launched{.job = id, .attempt = Attempt{1}});
  EXPECT_EQ(bench.at(id).state, State::running);
  bench.begin();
  EXPECT_EQ(bench.machine().standing().cores_in_use, 4U);
  EXPECT_TRUE(all_of<Launch>(bench.see(id, Running{})).empty());
  EXPECT_TRUE(all_of<Launch>(bench.see(id, NeverBegan{})).empty()) << "a late answer";
  bench.see(id, Ended{.kind = EndKind::finished});
  EXPECT_EQ(bench.at(id).state, State::done);
  bench.begin();
  EXPECT_EQ(bench.at(id).state, State::done);
  EXPECT_TRUE(bench.wait(100).empty());
}

TEST(Jobs, OfWhichAnOlderAttemptHoldsTheFolderWaitForIt) {
  Bench bench;
  const JobId id = bench.job();
  bench.step(LaunchFailed{.job = id, .attempt = Attempt{1}, .words = "wrongly"});
  bench.wait(1);
  EXPECT_EQ(bench.at(id).attempt, Attempt{2});
  const auto effects =
      bench.step(Sight{.job = id, .attempt = Attempt{1}, .seen = Running{.counts = {.scans = 3}}});
  ASSERT_EQ(all_of<Stop>(effects).size(), 1U);
  EXPECT_EQ(all_of<Stop>(effects)[0].attempt, Attempt{1});
  EXPECT_EQ(bench.at(id).counts.scans, 0U) << "it doesn't count";
}

TEST(Jobs, ThatWaitInABatchSystemAreStartingAndNothingIsCharged) {
  // Method: let a job of four cores wait for 1,000 s and then compute for 100 s. The job must be
  // charged 400 core-seconds.
  Bench bench;
  const JobId id = bench.job();
  bench.see(id, Pending{.words = "Slurm job 812 waits: Priority"});
  EXPECT_EQ(bench.at(id).state, State::starting);
  EXPECT_EQ(bench.at(id).words, "Slurm job 812 waits: Priority");
  for (int i = 0; i < 20; ++i) {
    EXPECT_TRUE(all_of<Launch>(bench.wait(50)).empty());
    bench.see(id, Pending{.words = "Slurm job 812 waits: Resources"});
  }
  EXPECT_EQ(bench.at(id).words, "Slurm job 812 waits: Resources");
  EXPECT_EQ(bench.at(id).attempt, Attempt{1});
  EXPECT_EQ(bench.at(id).core_seconds, 0);
  bench.step(LaunchFailed{.job = id, .attempt = Attempt{1}, .words = "late news"});
  bench.step(Launched{.job = id, .attempt = Attempt{1}});
  EXPECT_EQ(bench.at(id).state, State::running);
  bench.see(id, Pending{.words = "late news"});
  EXPECT_EQ(bench.at(id).state, State::running);
  EXPECT_NE(bench.at(id).words, "late news");
  bench.wait(100);
  bench.see(id, Ended{.kind = EndKind::finished});
  EXPECT_DOUBLE_EQ(bench.at(id).core_seconds, 400);
}

TEST(Jobs, ThatWaitInABatchSystemUseNothingOfTheirUsersLimit) {
  // Method: let a job of four cores wait for 1,000 s and then run for 100 s. The job's user has a
  // limit of 360 core-seconds a day.
  Bench bench({.limits = {.core_hours_per_day = 0.1}});
  const JobId id = bench.job();
  bench.see(id, Pending{});
  for (int i = 0; i < 20; ++i) {
    EXPECT_TRUE(all_of<Stop>(bench.wait(50)).empty());
    bench.see(id, Pending{});
  }
  EXPECT_EQ(bench.at(id).state, State::starting);
  bench.step(Launched{.job = id, .attempt = Attempt{1}});
  EXPECT_EQ(all_of<Stop>(bench.wait(100)).size(), 1U);
  EXPECT_EQ(bench.at(id).reason, Reason::limit_core_hours);
}

TEST(Jobs, ThatWaitInABatchSystemAreStoppedThereAtOnce) {
  for (const AskKind kind : {AskKind::cancel, AskKind::hold}) {
    Bench bench;
    const JobId id = bench.job();
    bench.see(id, Pending{});
    const auto effects = bench.step(Ask{.user = k_ann, .job = id, .kind = kind});
    ASSERT_EQ(all_of<Stop>(effects).size(), 1U);
    EXPECT_EQ(all_of<Stop>(effects)[0].how, StopHow::in_order);
    bench.see(id, Died{.outside = Outside::cancelled});
    EXPECT_EQ(bench.at(id).state, kind == AskKind::cancel ? State::cancelled : State::held);
    EXPECT_EQ(bench.at(id).deaths, 0U);
  }
}

TEST(Jobs, AskedToStopBeforeTheBatchSystemIsHeardOfAreStoppedThen) {
  Bench bench;
  const JobId id = bench.job();
  EXPECT_FALSE(bench.ask(id, AskKind::cancel));
  EXPECT_EQ(all_of<Stop>(bench.see(id, Pending{})).size(), 1U);
  EXPECT_TRUE(all_of<Stop>(bench.see(id, Pending{})).empty()) << "once is enough";
  EXPECT_EQ(all_of<Stop>(bench.wait(10)).size(), 1U) << "and again where nothing comes of it";
}

TEST(Jobs, CancelledInTheBatchSystemAreHeld) {
  // Method: use three attempts. The batch system stops the first attempt cleanly, kills the second
  // attempt, and removes the third attempt from its queue.
  const auto ends = std::vector<decltype(Sight::seen)>{
      Ended{.kind = EndKind::stop_requested,
            .outside = Outside::cancelled,
            .outside_words = "Slurm job 812: CANCELLED"},
      Ended{.signal = 9, .outside = Outside::cancelled},
      Died{.words = "Slurm job 812: CANCELLED.", .outside = Outside::cancelled}};
  for (const auto& end : ends) {
    Bench bench;
    const JobId id = bench.job();
    bench.see(id, Running{});
    bench.see(id, end);
    EXPECT_EQ(bench.at(id).state, State::held);
    EXPECT_EQ(bench.at(id).reason, Reason::cancelled_outside);
    EXPECT_NE(bench.at(id).words.find("`sleight resume 1`"), std::string::npos);
    EXPECT_EQ(bench.at(id).deaths, 0U);
    bench.step(BackendNote{.is_there = true});
    bench.wait(10'000);
    EXPECT_EQ(bench.at(id).state, State::held) << "nothing starts it again but its user";
    EXPECT_FALSE(bench.ask(id, AskKind::resume));
    EXPECT_EQ(bench.at(id).state, State::starting);
  }
}

TEST(Jobs, CancelledInTheBatchSystemAsTheyFinishAreDone) {
  Bench bench;
  const JobId id = bench.job();
  bench.see(id, Ended{.kind = EndKind::finished, .outside = Outside::cancelled});
  EXPECT_EQ(bench.at(id).state, State::done);
}

TEST(Jobs, WhosePlaceIsTakenGoOnAndAreNotCountedAsDead) {
  Bench bench;
  const JobId id = bench.job();
  for (int i = 0; i < 20; ++i) {
    bench.see(id, Running{});
    bench.see(id, Died{.words = "Slurm job 812: NODE_FAIL.", .outside = Outside::taken});
    EXPECT_EQ(bench.at(id).state, State::queued);
    EXPECT_EQ(bench.at(id).reason, Reason::taken_away);
    bench.wait(301);
    EXPECT_EQ(bench.at(id).state, State::starting);
  }
  EXPECT_EQ(bench.at(id).attempt, Attempt{21});
  EXPECT_EQ(bench.at(id).deaths, 0U);
}

TEST(Jobs, OfABatchSystemThatIsAwaySayWhy) {
  Bench bench;
  const JobId id = bench.job();
  bench.see(id, Unknown{.words = "Slurm doesn't answer"});
  EXPECT_EQ(bench.at(id).state, State::starting);
  EXPECT_EQ(bench.at(id).words, "Slurm doesn't answer");
}

TEST(Jobs, CancelledBeforeTheyBeganAreStoppedWhenTheyBegin) {
  Bench bench;
  const JobId id = bench.job();
  EXPECT_FALSE(bench.ask(id, AskKind::cancel));
  EXPECT_EQ(bench.at(id).state, State::yielding);
  const auto effects = bench.step(Launched{.job = id, .attempt = Attempt{1}});
  ASSERT_EQ(all_of<Stop>(effects).size(), 1U);
  bench.see(id, Ended{.kind = EndKind::stop_requested});
  EXPECT_EQ(bench.at(id).state, State::cancelled);
  EXPECT_FALSE(bench.ask(id, AskKind::cancel)) << "again is the same";
}

TEST(Jobs, ThatDontStopAreAskedAgainAndEnded) {
  Bench bench;
  const JobId id = bench.job();
  bench.step(Launched{.job = id, .attempt = Attempt{1}});
  bench.ask(id, AskKind::hold);
  EXPECT_EQ(all_of<Stop>(bench.wait(10)).at(0).how, StopHow::in_order);
  EXPECT_EQ(all_of<Stop>(bench.wait(600)).at(0).how, StopHow::now);
  bench.see(id, Ended{.signal = 9});
  EXPECT_EQ(bench.at(id).state, State::held);
  EXPECT_EQ(bench.at(id).deaths, 0U) << "our doing";
  bench.ask(id, AskKind::resume);
  EXPECT_EQ(bench.at(id).state, State::starting);
}

TEST(Jobs, AreHeldWhileTheDiskIsLow) {
  Bench bench;
  const JobId id = bench.job();
  bench.step(Launched{.job = id, .attempt = Attempt{1}});
  bench.room.disk_free_bytes = 9;
  EXPECT_EQ(all_of<Stop>(bench.step(bench.room)).size(), 1U);
  bench.see(id, Ended{.kind = EndKind::stop_requested});
  EXPECT_EQ(bench.at(id).state, State::held);
  const JobId later = bench.job(k_bob);
  EXPECT_EQ(bench.machine().waiting(later).why, WhyNot::disk_low);
  bench.wait(5);
  bench.room.disk_free_bytes = 11;
  EXPECT_TRUE(all_of<Launch>(bench.step(bench.room)).empty()) << "not for a moment above it";
  bench.room.disk_free_bytes = 20;
  EXPECT_EQ(all_of<Launch>(bench.step(bench.room)).size(), 2U);
}

TEST(Jobs, OfOtherResultsWaitForTheirPrograms) {
  Bench bench;
  bench.step(BackendNote{.results_version = "a"});
  const JobId id = bench.job();
  bench.see(id, Running{.results_version = "a"});
  bench.step(BackendNote{.results_version = "b"});
  EXPECT_EQ(bench.at(id).state, State::running) << "it runs on";
  bench.see(id, Died{});
  bench.wait(2);
  EXPECT_EQ(bench.at(id).state, State::held);
  EXPECT_EQ(bench.at(id).reason, Reason::other_results);
  bench.step(BackendNote{.results_version = "a"});
  EXPECT_EQ(bench.at(id).state, State::starting);
}

TEST(Jobs, WithoutABackendAreHeld) {
  Bench bench;
  const JobId id = bench.job();
  bench.step(LaunchFailed{.job = id, .attempt = Attempt{1}, .is_backend_away = true});
  EXPECT_EQ(bench.at(id).state, State::held);
  bench.wait(2);
  EXPECT_EQ(bench.at(id).state, State::starting) << "nobody said that it is away, so it is tried";
}

TEST(Jobs, OfAUserStayWithinItsLimits) {
  Options options;
  options.limits = {.jobs = 3, .cores = 2, .core_hours_per_day = 1};
  Bench bench(options);
  const JobId first = bench.job();
  const JobId second = bench.job(k_ann, {.cores = 1});
  EXPECT_EQ(bench.at(first).cores, 2U);
  EXPECT_EQ(bench.machine().waiting(second).why, WhyNot::limit_cores);
  EXPECT_EQ(bench.submit({}, {}, k_ann, {.ranks = 3}).refusal->kind, RefusalKind::over_limit);
  EXPECT_FALSE(bench.submit({}, {}).refusal);
  EXPECT_EQ(bench.submit({}, {}).refusal->kind, RefusalKind::over_limit) << "four jobs";
  EXPECT_FALSE(bench.machine().refusal_of({.user = k_bob}, 2));
  EXPECT_EQ(bench.machine().refusal_of({.user = k_bob}, 3)->kind, RefusalKind::over_limit);

  bench.step(Launched{.job = first, .attempt = Attempt{1}});
  bench.see(first, Running{.counts = {.scans = 1}});
  bench.wait(2000);
  EXPECT_EQ(bench.at(first).reason, Reason::limit_core_hours);
  bench.see(first, Ended{.kind = EndKind::stop_requested});
  EXPECT_EQ(bench.at(first).state, State::held);
  bench.wait(3600);
  EXPECT_EQ(bench.at(first).state, State::held);
  bench.wait(6 * 3600);
  EXPECT_EQ(bench.at(first).state, State::starting) << "a quarter of a day's has flowed back";
}

TEST(Jobs, TooLargeAreRefused) {
  Bench bench;
  EXPECT_EQ(bench.submit({}, {}, k_ann, {.ranks = 5}).refusal->kind, RefusalKind::too_large);
  EXPECT_EQ(bench.submit({}, {}, k_ann, {.ranks = 2, .memory_bytes = 501}).refusal->kind,
            RefusalKind::too_large);
  const JobId id = bench.job(k_ann, {.ranks = 4});
  bench.see(id, Died{});
  bench.room.cores = 2;
  bench.step(bench.room);
  bench.wait(2);
  EXPECT_EQ(bench.machine().waiting(id).why, WhyNot::too_large);
  bench.room.cores = 4;
  EXPECT_EQ(all_of<Launch>(bench.step(bench.room)).size(), 1U);
}

TEST(Jobs, ShareMemoryToo) {
  Bench bench;
  bench.job(k_ann, {.cores = 1, .memory_bytes = 600});
  const JobId second = bench.job(k_bob, {.cores = 1, .memory_bytes = 600});
  EXPECT_EQ(bench.at(second).state, State::queued);
  EXPECT_EQ(bench.machine().waiting(second).why, WhyNot::next);
}

TEST(Jobs, ComeByPriorityAndAge) {
  Bench bench;
  const JobId runs = bench.job();
  std::vector<JobId> ids;
  for (const std::int32_t priority : {0, 0, 3, 1}) {
    const auto effects = bench.step(Submit{.user = k_ann, .priority = priority});
    ids.push_back(all_of<Answer>(effects).at(0).job);
  }
  EXPECT_EQ(bench.machine().waiting(ids[2]).place, 1U);
  EXPECT_EQ(bench.machine().waiting(ids[3]).place, 2U);
  EXPECT_EQ(bench.machine().waiting(ids[0]).place, 3U);
  EXPECT_EQ(bench.machine().waiting(ids[1]).place, 4U);
  bench.see(runs, Ended{.kind = EndKind::finished});
  EXPECT_EQ(bench.at(ids[2]).state, State::starting);
}

TEST(Jobs, ExtendedGoOnAndResumedToo) {
  Bench bench;
  const JobId id = bench.job();
  bench.see(id, Ended{.kind = EndKind::finished, .digest = "d"});
  EXPECT_EQ(bench.ask(id, AskKind::resume)->kind, RefusalKind::wrong_state);
  EXPECT_FALSE(bench.ask(id, AskKind::extend));
  EXPECT_EQ(bench.at(id).state, State::starting);
  EXPECT_EQ(bench.at(id).attempt_revision, 2U);
  bench.see(id, Ended{.kind = EndKind::no_draws, .words = "why"});
  EXPECT_EQ(bench.at(id).state, State::failed);
  EXPECT_EQ(bench.at(id).words, "why");
  EXPECT_FALSE(bench.ask(id, AskKind::resume));
  EXPECT_EQ(bench.at(id).attempt, Attempt{3});
}

TEST(Jobs, AreDeletedAfterItWasSaid) {
  Options options;
  options.keep_s = 100;
  options.announce_s = 20;
  Bench bench(options);
  const JobId kept = bench.job();
  bench.see(kept, Ended{.kind = EndKind::finished});
  const JobId id = bench.job();
  bench.see(id, Ended{.kind = EndKind::finished});
  bench.ask(kept, AskKind::pin);
  EXPECT_TRUE(all_of<Announce>(bench.wait(70)).empty());
  const auto said = all_of<Announce>(bench.wait(20));
  ASSERT_EQ(said.size(), 1U);
  EXPECT_EQ(said[0].job, id);
  EXPECT_TRUE(all_of<Remove>(bench.wait(19)).empty());
  EXPECT_EQ(all_of<Remove>(bench.wait(2)).at(0).job, id);
  EXPECT_EQ(bench.machine().find(id), nullptr);
  EXPECT_EQ(all_of<Remove>(bench.begin()).size(), 1U) << "a daemon that was killed meanwhile";
  bench.step(Removed{id});
  EXPECT_EQ(bench.machine().all().size(), 1U);
  EXPECT_GT(bench.job(), id) << "an id is never given again";
}

TEST(Jobs, AreDeletedForRoomTheOldestFirst) {
  Options options;
  options.keep_bytes = 25;
  Bench bench(options);
  std::vector<JobId> ids;
  for (int i = 0; i < 3; ++i) {
    ids.push_back(bench.job());
    bench.see(ids.back(), Ended{.kind = EndKind::finished, .disk_bytes = 10});
    EXPECT_EQ(all_of<Announce>(bench.wait(1)).size(), i == 2 ? 1U : 0U);
  }
  EXPECT_TRUE(bench.at(ids[0]).remove_at_s);
  bench.ask(ids[0], AskKind::pin);
  EXPECT_FALSE(bench.at(ids[0]).remove_at_s) << "taken back";
}

TEST(Jobs, ArePinnedAgainstEverybody) {
  // Goal: no call can delete a pinned job.
  Bench bench;
  const JobId id = bench.job();
  bench.see(id, Ended{.kind = EndKind::finished});
  bench.ask(id, AskKind::pin);
  const auto refusal = bench.ask(id, AskKind::remove);
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->kind, RefusalKind::wrong_state);
  EXPECT_NE(refusal->what_to_do.find("--off"), std::string::npos);
  bench.ask(id, AskKind::unpin);
  EXPECT_FALSE(bench.ask(id, AskKind::remove));
}

TEST(Jobs, StopForADrainAndGoOnAfterIt) {
  Bench bench;
  const JobId id = bench.job();
  bench.step(Launched{.job = id, .attempt = Attempt{1}});
  EXPECT_EQ(all_of<Stop>(bench.step(Drain{true})).size(), 1U);
  bench.see(id, Ended{.kind = EndKind::stop_requested});
  EXPECT_EQ(bench.machine().waiting(id).why, WhyNot::draining);
  EXPECT_EQ(all_of<Launch>(bench.step(Drain{false})).size(), 1U);
}

TEST(Jobs, NamesAreReadBack) {
  for (int i = 0; i <= static_cast<int>(Reason::bug); ++i)
    EXPECT_EQ(reason_of(name_of(static_cast<Reason>(i))), static_cast<Reason>(i));
  for (int i = 0; i <= static_cast<int>(State::cancelled); ++i)
    EXPECT_EQ(state_of(name_of(static_cast<State>(i))), static_cast<State>(i));
  for (int i = 0; i <= static_cast<int>(EndKind::bug); ++i)
    EXPECT_EQ(end_kind_of(name_of(static_cast<EndKind>(i))), static_cast<EndKind>(i));
  EXPECT_FALSE(reason_of("nonsense"));
}

}  // namespace
}  // namespace sleight::jobs
