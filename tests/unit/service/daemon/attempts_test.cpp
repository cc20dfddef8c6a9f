// Goal: an attempt is reported as begun once its keeper has written a record. If the keeper exits
// earlier, the failure is reported at once. Method: run real keepers in an event loop. Let some
// keepers kill themselves at a given moment. A script replaces `sleight`.
#include "service/daemon/local_attempts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "common/base/clock.h"
#include "common/base/file_system.h"
#include "service/keeper/moments.h"
#include "tests/unit/service/keeper/job.h"

namespace sleight::daemon::attempts_test {

using ::testing::HasSubstr;

constexpr jobs::JobId k_job{1};
/// Timeout of a failing test. If no report arrived, the jobs' state machine would look at the
/// attempt after 5 s.
constexpr double k_patience_s = 20;

class AttemptsTest : public keeper::testing::JobTest {
 protected:
  AttemptsTest() : folders_(folder()), feeds_(folders_, clock_, [](jobs::JobId) {}) {
    program_is("[ \"$1\" = --version ] && { echo results 1; exit 0; }; exec sleep 1000");
  }

  /// Launches an attempt and returns the first input that follows. If `dies_at` is set, the
  /// attempt's keeper dies at that moment.
  jobs::Input first_heard(std::optional<keeper::Moment> dies_at) {
    const keeper::LocalBackend backend = this->backend(dies_at.has_value());
    rpc::Loop loop;
    std::optional<jobs::Input> heard;
    const auto give_up = loop.call_later(k_patience_s, [&] { loop.stop(); });
    LocalAttempts attempts({.loop = loop,
                            .clock = clock_,
                            .files = files_,
                            .folders = folders_,
                            .feeds = feeds_,
                            .backend = backend,
                            .text_of = [](auto, auto) { return LaunchText{.request = "# none\n"}; },
                            .hear =
                                [&](jobs::Input input) {
                                  if (heard || std::holds_alternative<jobs::BackendNote>(input))
                                    return;
                                  heard = std::move(input);
                                  seen_ = backend.look(folders_.folder(k_job), 1);
                                  loop.stop();
                                }});
    if (dies_at) {
      const std::string name(keeper::k_moment_names.at(static_cast<std::size_t>(*dies_at)));
      ::setenv("SLEIGHT_KEEPER_DIES_AT", name.c_str(), 1);
    }
    attempts.launch({.job = k_job, .attempt = jobs::Attempt{1}, .cores = 1});
    ::unsetenv("SLEIGHT_KEEPER_DIES_AT");
    loop.run();
    EXPECT_TRUE(heard) << "nothing was heard";
    return heard.value_or(jobs::Tick{});
  }

  base::SteadyClock clock_;
  base::PosixFileSystem files_;
  JobFolders folders_;
  Feeds feeds_;
  keeper::Look seen_{};  ///< result of a look when the first input arrived
};

TEST_F(AttemptsTest, HaveBegunOnceThereIsARecord) {
  const jobs::Input heard = first_heard(std::nullopt);
  EXPECT_TRUE(std::holds_alternative<jobs::Launched>(heard));
  EXPECT_EQ(seen_.state, keeper::Look::State::running);
  EXPECT_TRUE(seen_.record.has_value());
}

TEST_F(AttemptsTest, WhoseKeeperEndsBeforeTheRecordHaveNotBegun) {
  for (const auto moment :
       {keeper::Moment::begun, keeper::Moment::locked, keeper::Moment::prepared}) {
    const jobs::Input heard = first_heard(moment);
    const auto* failed = std::get_if<jobs::LaunchFailed>(&heard);
    ASSERT_TRUE(failed) << static_cast<int>(moment);
    EXPECT_EQ(failed->job, k_job);
    EXPECT_EQ(failed->attempt, jobs::Attempt{1});
    EXPECT_EQ(failed->hindrance, jobs::Hindrance::none);
    EXPECT_THAT(failed->words, HasSubstr("keeper"));
    EXPECT_EQ(seen_.state, keeper::Look::State::never_began);
  }
}

TEST_F(AttemptsTest, WhoseKeeperEndsRightAfterTheRecordHaveDied) {
  // The record may or may not be seen before the death. In both cases the first report is Launched
  // or Died, never a failed launch.
  const jobs::Input heard = first_heard(keeper::Moment::recorded);
  const auto* sight = std::get_if<jobs::Sight>(&heard);
  EXPECT_TRUE(std::holds_alternative<jobs::Launched>(heard) ||
              (sight && std::holds_alternative<jobs::Died>(sight->seen)));
}

// If a stop's signal kills a program that can't handle signals yet, the program counts as stopped,
// not as died.
TEST_F(AttemptsTest, ToldToStopBeforeItListensItStoppedInOrder) {
  AttemptSights sights({.clock = clock_, .folders = folders_, .feeds = feeds_});
  keeper::AttemptRecord record{.attempt = 1, .end = keeper::AttemptEnd{.signal = SIGUSR1}};
  EXPECT_EQ(sights.ended(k_job, record, {}).kind, jobs::EndKind::none);
  record.end->stop_asked = keeper::Stop::in_order;
  EXPECT_EQ(sights.ended(k_job, record, {}).kind, jobs::EndKind::stop_requested);
  record.end->signal = SIGSEGV;
  EXPECT_EQ(sights.ended(k_job, record, {}).kind, jobs::EndKind::none);
}

}  // namespace sleight::daemon::attempts_test
