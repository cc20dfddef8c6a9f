// Goal: if a keeper dies at any moment, look() returns how far the attempt got, and no process is
// left. The daemon repeats an attempt that never began, and starts the next attempt after a death.
// So each attempt's program starts at most once. Method: kill keepers at each moment of an attempt
// and at random times.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <string>

#include "common/random/purpose.h"
#include "common/random/stream.h"
#include "service/keeper/backend.h"
#include "service/keeper/moments.h"
#include "tests/support/property.h"
#include "tests/unit/service/keeper/job.h"

namespace sleight::keeper {
namespace {

constexpr std::uint64_t k_seed = 2025;

class DeathsTest : public testing::JobTest {
 protected:
  /// Returns the state after the keeper's death. If a child hasn't called exec yet, it holds the
  /// lock until the kernel kills it.
  Look look_after(const RunningKeeper& keeper, std::uint32_t attempt) const {
    EXPECT_TRUE(testing::comes_true([&] { return keeper.has_gone(); }));
    Look look;
    EXPECT_TRUE(testing::comes_true([&] {
      look = backend().look(folder(), attempt);
      return look.state != Look::State::running;
    }));
    EXPECT_TRUE(testing::comes_true([&] { return testing::processes_with(folder()).empty(); }));
    return look;
  }
};

Look::State state_after(Moment moment) {
  if (moment < Moment::recorded) return Look::State::never_began;
  return moment < Moment::end_recorded ? Look::State::died : Look::State::ended;
}

TEST_F(DeathsTest, AtEachMoment) {
  // The program writes one line when it starts. If the keeper was killed before exec, there is no
  // line.
  std::uint32_t attempt = 0;
  std::size_t runs = 0;
  for (std::size_t i = 0; i < k_moment_names.size(); ++i) {
    const auto moment = static_cast<Moment>(i);
    const bool waits = moment < Moment::program_ended;
    program_is(std::string("echo run >> runs; ") + (waits ? "sleep 1000" : "exit 0"));
    ++attempt;
    ::setenv("SLEIGHT_KEEPER_DIES_AT", std::string(k_moment_names[i]).c_str(), 1);
    const auto keeper = backend(true).launch(spec(attempt));
    ::unsetenv("SLEIGHT_KEEPER_DIES_AT");
    const Look look = look_after(keeper, attempt);
    EXPECT_EQ(look.state, state_after(moment)) << k_moment_names[i];
    const std::size_t runs_now = lines_in("runs").size();
    EXPECT_GE(runs_now, moment > Moment::started ? runs + 1 : runs) << k_moment_names[i];
    EXPECT_LE(runs_now, moment > Moment::in_child ? runs + 1 : runs) << k_moment_names[i];
    runs = runs_now;
    // If the attempt is launched again, the program runs only if the attempt never began.
    program_is("echo run >> runs");
    const Look second = look_after(backend().launch(spec(attempt)), attempt);
    runs += look.state == Look::State::never_began ? 1 : 0;
    EXPECT_EQ(lines_in("runs").size(), runs) << k_moment_names[i];
    EXPECT_EQ(second.state,
              look.state == Look::State::never_began ? Look::State::ended : look.state);
    EXPECT_EQ(run(spec(++attempt)).exit_code, 0);
    ++runs;
  }
  EXPECT_EQ(lines_in("runs").size(), runs);
}

TEST_F(DeathsTest, AtRandomTimes) {
  // Method: launch a program that takes 10 ms. Kill the keeper at a random time up to 30 ms after
  // the launch. Then launch attempts by the daemon's rule until an attempt has ended. Each attempt
  // must write its number at most once.
  program_is("cat attempt.json | tr ',' '\\n' | grep -m1 '\"attempt\"' >> runs; sleep 0.01");
  std::uint32_t attempt = 0;
  for (const std::uint64_t n : property::in_turn(property::long_run() ? 300 : 15)) {
    random::Stream stream({.seed = k_seed, .purpose = random::Purpose::prior}, n);
    ++attempt;
    Look look;
    for (bool kills = true; look.state != Look::State::ended; kills = false) {
      const auto keeper = backend().launch(spec(attempt));
      if (kills) {
        ::usleep(static_cast<useconds_t>(stream.bits() % 30'000));
        ::kill(keeper.identity().pid, SIGKILL);
      }
      look = look_after(keeper, attempt);
      ASSERT_NE(look.state, Look::State::running);
      if (look.state == Look::State::died) ++attempt;
    }
  }
  auto runs = lines_in("runs");
  std::sort(runs.begin(), runs.end());
  EXPECT_EQ(std::unique(runs.begin(), runs.end()), runs.end());
  EXPECT_LE(runs.size(), attempt);
}

}  // namespace
}  // namespace sleight::keeper
