// Goal: the event log of a run keeps the newest events, and can be read while the run writes it.
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
  // Goal: a new session appends to the log of a killed session, and removes an incomplete last
  // line. Method: open a log in three sessions. Between the sessions, append damaged and incomplete
  // lines to the file.
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
  EXPECT_EQ(read_event_log(folder()).size(), 3U);  // the incomplete line is ignored
  EventLog log(folder());
  log.append({.what = Phase{.words = "b"}});
  const auto events = read_event_log(folder());
  ASSERT_EQ(events.size(), 4U);
  EXPECT_EQ(events[0].number, 1U);
  EXPECT_EQ(std::get<Phase>(events[1].what).words, "a");
  EXPECT_EQ(events[2].number, 2U);
}

TEST_F(EventLogTest, IsBoundedAndKeepsTheNewest) {
  // Goal: a log never exceeds its size limit and keeps the newest events without a gap. A long log
  // is not much smaller than half of the limit.
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
  // Goal: a reader always sees consecutive event numbers, and the newest number never decreases.
  // Method: read the log in one thread, while another thread appends events and often rotates the
  // files.
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

/// While a FullDisk exists, no file can grow beyond a limit, as on a full disk.
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
  // Goal: on a full disk, the log loses events but never keeps part of a line. About a second after
  // somebody frees space or deletes the log, writing resumes. Method: limit the size of files for a
  // while. Move a manual clock.
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
  // Goal: if a log can't be written, its events are lost and the run continues. Method: write a log
  // into a missing folder. Put a folder in the place of the rotated log.
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
