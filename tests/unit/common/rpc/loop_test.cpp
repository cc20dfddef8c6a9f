// Goal: the event loop calls timers, file callbacks, posted functions and signal handlers at the
// right time. Method: use short real times and pipes.
#include "common/rpc/loop.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <optional>
#include <stdexcept>
#include <thread>
#include <vector>

namespace sleight::rpc {
namespace {

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

TEST(LoopTest, CallsInTimeAndInOrder) {
  // Goal: timers fire in order of time and never early. If a timer is destroyed, it doesn't fire.
  // Method: start several timers. Destroy one timer at once, and let a callback destroy another
  // timer.
  Loop loop;
  const double began_s = now_s();
  std::vector<int> called;
  std::optional<Loop::Handle> ended = loop.call_later(0.04, [&] { called.push_back(9); });
  const auto second = loop.call_later(0.03, [&] {
    called.push_back(2);
    EXPECT_GE(now_s() - began_s, 0.03);
  });
  const auto first = loop.call_later(0.01, [&] {
    called.push_back(1);
    ended.reset();
  });
  {
    const auto dropped = loop.call_later(0.005, [&] { called.push_back(8); });
  }
  const auto last = loop.call_later(0.06, [&] { loop.stop(); });
  loop.run();
  EXPECT_EQ(called, (std::vector<int>{1, 2}));
}

TEST(LoopTest, CountsFromTheCallAlsoAfterALongCallback) {
  // Goal: a timer's delay begins when the timer is requested, not when the loop last woke up.
  // Method: run a callback that takes 50 ms and then requests a delay of 20 ms.
  Loop loop;
  double asked_s = 0.0;
  double called_s = 0.0;
  std::optional<Loop::Handle> second;
  const auto first = loop.call_later(0.001, [&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    asked_s = now_s();
    second = loop.call_later(0.02, [&] {
      called_s = now_s();
      loop.stop();
    });
  });
  loop.run();
  EXPECT_GE(called_s - asked_s, 0.02);
}

TEST(LoopTest, CallsAgainAndAgainUntilTheHandleGoes) {
  // Goal: an interval timer repeats until its handle is destroyed. The timer's own callback may
  // destroy it. Method: destroy the handle in the fifth call, and check that no sixth call follows.
  Loop loop;
  int count = 0;
  std::optional<Loop::Handle> every;
  std::optional<Loop::Handle> end;
  every = loop.call_every(0.002, [&] {
    if (++count != 5) return;
    end = loop.call_later(0.1, [&] { loop.stop(); });
    every.reset();
  });
  loop.run();
  EXPECT_EQ(count, 5);
}

TEST(LoopTest, LooksAtFilesUntilTheyAreRead) {
  // Goal: a file callback is called as long as data is readable, even after a partial read. The
  // callback is also called when the other end closes. Method: read one byte of a pipe in each
  // call.
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  Loop loop;
  std::string read;
  bool is_closed = false;
  std::optional<Loop::Handle> handle;
  handle = loop.call_when_readable(ends[0], [&] {
    char c = 0;
    if (::read(ends[0], &c, 1) == 1) {
      read += c;
    } else {
      is_closed = true;
      handle.reset();
      ::close(ends[0]);
      loop.stop();
    }
  });
  ASSERT_EQ(::write(ends[1], "ab", 2), 2);
  const auto more = loop.call_later(0.01, [&] { ASSERT_EQ(::write(ends[1], "cd", 2), 2); });
  const auto close = loop.call_later(0.03, [&] { ::close(ends[1]); });
  loop.run();
  EXPECT_EQ(read, "abcd");
  EXPECT_TRUE(is_closed);
}

TEST(LoopTest, TakesPostsFromOtherThreadsInOrder) {
  // Goal: functions that other threads post run on the loop's thread. If one thread posts several
  // functions, they run in that order. Method: post one function before run(), and 500 functions
  // from each of four threads.
  Loop loop;
  const auto here = std::this_thread::get_id();
  std::vector<int> next(4, 0);
  int count = 0;
  loop.post([&] { ++count; });
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 500; ++i) {
        loop.post([&, t, i] {
          EXPECT_EQ(std::this_thread::get_id(), here);
          EXPECT_EQ(next[static_cast<std::size_t>(t)]++, i);
          if (++count == 2001) loop.stop();
        });
      }
    });
  }
  loop.run();
  for (std::thread& thread : threads)
    thread.join();
  EXPECT_EQ(count, 2001);
}

TEST(LoopTest, EndsWithWhatACallbackThrows) {
  // Goal: run() rethrows a callback's exception and can be called again.
  Loop loop;
  loop.post([] { throw std::runtime_error("the callback"); });
  EXPECT_THROW(loop.run(), std::runtime_error);
  loop.stop();
  loop.run();
}

TEST(LoopTest, HearsStopSignalsAndBlocksNone) {
  // Goal: the loop reports SIGTERM, SIGINT and SIGHUP, even several at once. No signal is blocked,
  // because child processes would inherit the blocked signals.
  std::vector<int> heard;
  {
    Loop loop;
    loop.on_stop_signals([&](int signal) {
      heard.push_back(signal);
      if (heard.size() == 2) ::raise(SIGINT);
      if (heard.size() == 3) loop.stop();
    });
    loop.post([] {
      ::raise(SIGHUP);
      ::raise(SIGTERM);
    });
    loop.run();
    sigset_t mask;
    ASSERT_EQ(::pthread_sigmask(SIG_SETMASK, nullptr, &mask), 0);
    for (const int signal : {SIGTERM, SIGINT, SIGHUP, SIGUSR1, SIGCHLD})
      EXPECT_EQ(sigismember(&mask, signal), 0);
  }
  EXPECT_EQ(heard, (std::vector<int>{SIGTERM, SIGHUP, SIGINT}));
}

}  // namespace
}  // namespace sleight::rpc
