// Goal: a run's event log keeps the newest events, and readers see them while it is written.
// Method: use real files, threads and limits.
#include "common/events/event_log.h"

#include <gtest/gtest.h>

#include <sys/resource.h>

#include <atomic>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <thread>

#include "common/base/clock.h"
#include "tests/support/property.h"
#include "tests/unit/common/archive/hdf5/scratch.h"

namespace sleight::events {
namespace {

class EventLogTest : public archive::testing::Scratch {
 protected:
  static RunEvent numbered(std::uint64_t number) {
    return {.number = number, .what = RoundEnded{.round = number, .scans = 2 * number}};
  }
  std::uint64_t bytes() const {
    std::uint64_t sum = 0;
    for (const std::string& name : names())
      sum += std::filesystem::file_size(path(name));
    return sum;
  }
  std::string folder() const { return path("."); }
};

TEST_F(EventLogTest, GoesOnOverSessionsAndTornLines) {
  // Goal: a new session appends to a killed session's log and drops its incomplete line. Method:
  // run three sessions with an incomplete line and a damaged line between them.
  EXPECT_TRUE(read_event_log(folder()).empty());
  EXPECT_TRUE(read_event_log(path("nowhere")).empty());
  {
    EventLog log(folder());
    log.append(numbered(1));
    log.append({.what = Phase{.words = "a"}});
  }
  std::ofstream(path("events.log"), std::ios::app) << "no event\n{\"number\":2,\"ki";
  {
    EventLog log(folder());
    log.append(numbered(2));
  }
  std::ofstream(path("events.log"), std::ios::app) << "{";
  EXPECT_EQ(read_event_log(folder()).size(), 3U);  // the file is still open for writing
  EventLog log(folder());
  log.append({.what = Phase{.words = "b"}});
  const auto events = read_event_log(folder());
  ASSERT_EQ(events.size(), 4U);
  EXPECT_EQ(events[0].number, 1U);
  EXPECT_EQ(std::get<Phase>(events[1].what).words, "a");
  EXPECT_EQ(events[2].number, 2U);
}

TEST_F(EventLogTest, IsBoundedAndKeepsTheNewest) {
  // Goal: a log stays within its bound, holds the newest events without a gap, and fills at least
  // half the bound. Method: append many events under a small bound.
  constexpr std::uint64_t k_bytes_max = 10'000;
  EventLog log(folder(), k_bytes_max);
  for (std::uint64_t number = 1; number <= 2000; ++number) {
    log.append(numbered(number));
    ASSERT_LE(bytes(), k_bytes_max);
    if (number % 97 != 0) continue;
    const auto events = read_event_log(folder());
    for (std::size_t i = 1; i < events.size(); ++i)
      ASSERT_EQ(events[i].number, events[i - 1].number + 1);
    ASSERT_EQ(events.back().number, number);
    if (number > 200) {
      ASSERT_GE(bytes(), k_bytes_max / 2 - 200);
    }
  }
}

TEST_F(EventLogTest, ReadersSeeNoGapWhileItTurnsOver) {
  // Goal: a reader sees consecutive numbers at any moment, and its newest number never decreases.
  // Method: a thread reads all the time while a writer rotates its files every few events.
  std::atomic<bool> is_over = false;
  std::atomic<std::uint64_t> looks = 0;
  std::optional<std::string> complaint;
  std::thread reader([&] {
    std::uint64_t last = 0;
    while (!is_over && !complaint) {
      const auto events = read_event_log(folder());
      ++looks;
      for (std::size_t i = 1; i < events.size(); ++i) {
        if (events[i].number != events[i - 1].number + 1) complaint = "a gap";
      }
      if (events.empty()) continue;
      if (events.back().number < last) complaint = "fewer than before";
      last = events.back().number;
    }
  });
  {
    EventLog log(folder(), 2'000);
    const std::uint64_t events = property::of_tier(4'000, 20'000);
    for (std::uint64_t number = 1; number <= events || looks < 50; ++number)
      log.append(numbered(number));
  }
  is_over = true;
  reader.join();
  EXPECT_EQ(complaint, std::nullopt);
}

/// Limits the size of files during its lifetime, as a full disk does.
class FullDisk {
 public:
  explicit FullDisk(std::uint64_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() { ::setrlimit(RLIMIT_FSIZE, &before_); }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit before_{};
};

TEST_F(EventLogTest, GoesOnWhenThereIsRoomAgain) {
  // Goal: a full disk never splits a line and loses only the lines written meanwhile. The log
  // resumes a second after space is free again, or after somebody deletes it. Method: lift a
  // file-size limit after a while, with a manual clock.
  base::ManualClock clock;
  EventLog log(folder(), k_event_log_bytes_max, clock);
  log.append(numbered(1));
  {
    const FullDisk full(bytes() + 20);
    log.append(numbered(2));
    clock.advance(2);
    log.append(numbered(3));
  }
  log.append(numbered(4));
  ASSERT_EQ(read_event_log(folder()).size(), 1U);
  clock.advance(2);
  log.append(numbered(5));
  const auto events = read_event_log(folder());
  ASSERT_EQ(events.size(), 2U);
  EXPECT_EQ(events[1].number, 5U);

  std::filesystem::remove(event_log_path(folder()));
  log.append(numbered(6));
  EXPECT_TRUE(read_event_log(folder()).empty());
  clock.advance(2);
  log.append(numbered(7));
  ASSERT_EQ(read_event_log(folder()).size(), 1U);
  EXPECT_EQ(read_event_log(folder())[0].number, 7U);
}

TEST_F(EventLogTest, ADiskThatFailsEndsNothing) {
  // Goal: a log that can't be written is abandoned without stopping the run. Method: use a missing
  // folder, and a rotated log whose name a folder occupies.
  EventLog nowhere(path("nowhere"));
  nowhere.append(numbered(1));
  EventLog log(folder(), 1'000);
  std::filesystem::create_directories(path("events.old.log/x"));
  for (std::uint64_t number = 1; number <= 100; ++number)
    log.append(numbered(number));
  EXPECT_LE(std::filesystem::file_size(path("events.log")), 500U);
}

}  // namespace
}  // namespace sleight::events
