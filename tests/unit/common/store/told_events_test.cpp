// Goal: a run's events are numbered and committed together with its results. Readers get events
// from the event log and from the store.
#include "common/store/told_events.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <optional>
#include <thread>

#include "common/base/error.h"
#include "common/events/event_log.h"
#include "common/store/run_store.h"
#include "common/store/sessions.h"
#include "tests/unit/common/store/examples.h"

namespace sleight::store {
namespace {

using testing::example_identity;
using ::testing::HasSubstr;
using testing::result_of;

events::RunEvent round_of(std::uint64_t round) {
  return {.what = events::RoundEnded{.round = round, .scans = 3 * round}};
}

PutEvents rounds(std::uint64_t first, std::uint64_t count) {
  PutEvents put;
  for (std::uint64_t nth = 0; nth < count; ++nth)
    put.events.push_back(round_of(first + nth));
  put.reached = {.scans = first + count, .solutions = count, .failures = first};
  return put;
}

std::vector<std::uint64_t> numbers_of(const std::vector<events::RunEvent>& events) {
  std::vector<std::uint64_t> numbers;
  for (const events::RunEvent& event : events)
    numbers.push_back(event.number);
  return numbers;
}

std::vector<std::uint64_t> from_to(std::uint64_t first, std::uint64_t last) {
  std::vector<std::uint64_t> numbers;
  for (std::uint64_t number = first; number <= last; ++number)
    numbers.push_back(number);
  return numbers;
}

class ToldEventsTest : public testing::RunFolder {
 protected:
  void execute(const std::string& sql) const {
    Database(RunStore::database_path(folder()), Access::read_write).execute(sql);
  }
  std::string failure() const {
    try {
      (void)events_told(folder(), 1, 100);
    } catch (const base::Error& error) {
      return error.what();
    }
    return {};
  }
  /// Writes a log of numbered rounds, as a session does.
  void log(std::uint64_t first, std::uint64_t last) const {
    events::EventLog log(folder());
    for (std::uint64_t number = first; number <= last; ++number) {
      events::RunEvent event = round_of(number);
      event.number = number;
      log.append(event);
    }
  }
  void store_rounds(std::uint64_t count) const {
    RunStore store(folder(), example_identity(1));
    store.put(rounds(1, count));
    store.flush();
  }
};

TEST_F(ToldEventsTest, NumbersGoOnOverSessionsAndEnds) {
  // Goal: events are numbered from 1 without a gap, in the order of put(). A session's end is an
  // event too. If a session dies, it stores no end, and told() returns the counts of the last
  // committed events. Method: run three sessions. The second dies. Compare the events that each
  // session reports with the events that are read back.
  std::vector<std::uint64_t> heard;
  const auto hear = [&](std::span<const events::RunEvent> told) {
    for (const events::RunEvent& event : told)
      heard.push_back(event.number);
  };
  {
    RunStore store(folder(), example_identity(1));
    EXPECT_EQ(store.told(), ToldFrontier{});
    store.on_told(hear);
    store.put(result_of(0, 0, 4));
    store.put(rounds(1, 2));
    store.put(rounds(3, 1));
    EXPECT_EQ(store.close({.end = events::End::time_limit, .words = "so"}), 4U);
  }
  {
    RunStore died(folder(), example_identity(1));
    EXPECT_EQ(died.told(), rounds(3, 1).reached);
    died.on_told(hear);
    died.put(rounds(4, 1));
  }
  RunStore store(folder(), example_identity(1));
  EXPECT_EQ(store.told(), rounds(4, 1).reached);
  EXPECT_EQ(store.close({.end = events::End::finished}), 6U);
  EXPECT_EQ(heard, (std::vector<std::uint64_t>{1, 2, 3, 5}));

  const std::vector<events::RunEvent> all = events_told(folder(), 1, 100);
  ASSERT_EQ(numbers_of(all), from_to(1, 6));
  EXPECT_EQ(std::get<events::RoundEnded>(all[4].what).round, 4U);
  const auto& first_end = std::get<events::RunEnd>(all[3].what);
  EXPECT_EQ(first_end, sessions_of(folder()).front().end);
  EXPECT_EQ(first_end.epoch, 1U);
  EXPECT_EQ(std::get<events::RunEnd>(all[5].what).epoch, 3U);
}

TEST_F(ToldEventsTest, AreCommittedBehindTheirResultsAndFenced) {
  // Goal: an event is reported only after its results are committed. A session that is presumed
  // dead reports nothing. Method: at each report, read the results from the store. Then open a
  // newer session. The store must refuse the older session's events and end.
  RunStore store(folder(), example_identity(1));
  std::uint64_t heard = 0;
  store.on_told([&](std::span<const events::RunEvent> told) {
    heard += told.size();
    EXPECT_EQ(testing::stored(folder(), 0, 5 * heard).size(), 5 * heard);
  });
  for (std::uint64_t nth = 0; nth < 20; ++nth) {
    store.put(result_of(0, 5 * nth, 5));
    store.put(rounds(nth + 1, 1));
    if (nth % 7 == 0) store.flush();
  }
  store.flush();
  EXPECT_EQ(heard, 20U);

  RunStore newer(folder(), example_identity(1));
  store.put(rounds(21, 1));
  EXPECT_THROW(store.flush(), base::Error);
  EXPECT_THROW((void)store.close({.end = events::End::failed}), base::Error);
  EXPECT_EQ(heard, 20U);
  EXPECT_EQ(newer.close({.end = events::End::finished}), 21U);
}

TEST_F(ToldEventsTest, EventsAloneAreCommittedSoon) {
  // Goal: an event is committed soon, even without a flush or further results.
  RunStore store(folder(), example_identity(1));
  std::atomic<bool> has_heard = false;
  store.on_told([&](std::span<const events::RunEvent>) { has_heard = true; });
  store.put(rounds(1, 1));
  for (int tries = 0; tries < 1000 && !has_heard; ++tries)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_TRUE(has_heard);
}

TEST_F(ToldEventsTest, WhatTheLogHasLostComesFromTheStore) {
  // Goal: a reader gets each event once and in order, even if the log lacks some events. Method:
  // store twenty events. Write logs that have all events, the last events, the first events, some
  // middle events, or no events. Damage a line of a log. Begin at several numbers, and limit the
  // events per call.
  store_rounds(20);
  const auto read_all = [&](std::uint64_t first, std::size_t at_once) {
    ToldEvents told(folder(), first);
    std::vector<std::uint64_t> numbers;
    while (true) {
      const auto some = numbers_of(told.rest(at_once));
      EXPECT_LE(some.size(), at_once);
      if (some.empty()) return numbers;
      numbers.insert(numbers.end(), some.begin(), some.end());
    }
  };
  const std::string path = events::event_log_path(folder());
  for (const auto& [first, last] : std::vector<std::pair<std::uint64_t, std::uint64_t>>{
           {1, 20}, {15, 20}, {1, 5}, {8, 9}, {1, 0}}) {
    std::filesystem::remove(path);
    log(first, last);
    for (const std::size_t at_once : {1, 3, 7, 20, 100}) {
      EXPECT_EQ(read_all(1, at_once), from_to(1, 20)) << first << " to " << last;
      EXPECT_EQ(read_all(11, at_once), from_to(11, 20)) << first << " to " << last;
      EXPECT_EQ(read_all(21, at_once), from_to(21, 20));
    }
  }
  std::filesystem::remove(path);
  log(1, 20);
  std::string text = bytes_of(path);
  text[text.size() / 2] = '\n';
  put_bytes(path, text);
  EXPECT_EQ(read_all(1, 100), from_to(1, 20));
  // If an event is neither in the log nor in the store, a reader reports the gap.
  std::filesystem::remove(path);
  log(22, 22);
  EXPECT_THAT(failure(), HasSubstr("event 21 is missing"));
}

TEST_F(ToldEventsTest, FollowsALogThatTurnsOverOrIsDeleted) {
  // Goal: a follower gets each event exactly once while the log rotates, is deleted or is created
  // again. If there are no new events, the follower gets nothing. Method: store all events. Write
  // the events to a small log, and delete the log several times. One follower reads after each
  // event; the other reads after every ninth event.
  store_rounds(2000);
  ToldEvents quick(folder());
  ToldEvents slow(folder());
  std::vector<std::uint64_t> quick_has;
  std::vector<std::uint64_t> slow_has;
  const auto ask = [](ToldEvents& told, std::vector<std::uint64_t>& has, std::size_t at_once) {
    for (const std::uint64_t number : numbers_of(told.next(at_once)))
      has.push_back(number);
  };
  EXPECT_TRUE(quick.next(5).empty());  // there is no log yet
  std::optional<events::EventLog> log(std::in_place, folder(), 3000);
  for (std::uint64_t number = 1; number <= 2000; ++number) {
    events::RunEvent event = round_of(number);
    event.number = number;
    log->append(event);
    ask(quick, quick_has, 5);
    ASSERT_EQ(quick_has.size(), number);
    if (number % 9 == 0) ask(slow, slow_has, 11);
    if (number % 501 == 0) {
      std::filesystem::remove(events::event_log_path(folder()));
      if (number % 2 == 0) std::filesystem::remove(events::old_event_log_path(folder()));
      log.emplace(folder(), 3000);
    }
  }
  EXPECT_TRUE(quick.next(5).empty());
  while (slow.number() <= 2000)
    ask(slow, slow_has, 100);
  EXPECT_EQ(quick_has, from_to(1, 2000));
  EXPECT_EQ(slow_has, from_to(1, 2000));
}

TEST_F(ToldEventsTest, TellsTheNewestOfWhatHasNoNumber) {
  // Goal: some kinds of events have no number, such as progress. A reader gets the numbered events
  // first, and then the newest unread event of each kind without numbers.
  store_rounds(1);
  events::EventLog log(folder());
  log.append({.what = events::Phase{.words = "a"}});
  log.append({.what = events::Progress{.scans_done = 1}});
  log.append({.what = events::Phase{.words = "b"}});
  events::RunEvent numbered = round_of(1);
  numbered.number = 1;
  log.append(numbered);
  log.append({.what = events::Progress{.scans_done = 2}});
  ToldEvents told(folder());
  const auto events = told.next(10);
  ASSERT_EQ(numbers_of(events), (std::vector<std::uint64_t>{1, 0, 0}));
  EXPECT_EQ(std::get<events::Phase>(events[1].what).words, "b");
  EXPECT_EQ(std::get<events::Progress>(events[2].what).scans_done, 2U);
  EXPECT_TRUE(told.next(10).empty());
  log.append({.what = events::Phase{.words = "b"}});
  EXPECT_EQ(told.next(10).size(), 1U);
}

TEST_F(ToldEventsTest, ReadsBesideAWriter) {
  // Goal: while a session commits and logs events, a follower in another thread gets each event
  // once and in order.
  constexpr std::uint64_t k_events = 3000;
  std::atomic<bool> is_over = false;
  std::vector<std::uint64_t> has;
  std::optional<std::string> complaint;
  std::thread reader([&] {
    try {
      ToldEvents told(folder());
      while (has.size() < k_events && !complaint) {
        const bool was_over = is_over;
        const auto some = numbers_of(was_over ? told.rest(50) : told.next(50));
        has.insert(has.end(), some.begin(), some.end());
        if (was_over && some.empty()) break;
      }
    } catch (const std::exception& failure) {
      complaint = failure.what();
    }
  });
  {
    RunStore store(folder(), example_identity(1));
    events::EventLog log(folder(), 20'000);
    store.on_told([&](std::span<const events::RunEvent> told) {
      for (const events::RunEvent& event : told)
        if (event.number % 10 != 0) log.append(event);
    });
    for (std::uint64_t number = 1; number <= k_events; ++number) {
      store.put(rounds(number, 1));
      if (number % 200 == 0) store.flush();
    }
    store.flush();
  }
  is_over = true;
  reader.join();
  EXPECT_EQ(complaint, std::nullopt);
  EXPECT_EQ(has, from_to(1, k_events));
}

TEST_F(ToldEventsTest, WhatWasChangedIsRefused) {
  // Goal: readers and sessions refuse a damaged row. Method: change each column in turn.
  EXPECT_EQ(failure(), "");  // no run yet
  store_rounds(3);
  EXPECT_EQ(failure(), "");
  for (const char* change :
       {"number=number+10", "line=replace(line, '6', '7')", "line=''", "checksum=checksum+1"}) {
    execute("CREATE TABLE copy AS SELECT * FROM event");
    execute(fmt::format("UPDATE event SET {} WHERE number=2", change));
    EXPECT_THAT(failure(), HasSubstr("damaged: event 2")) << change;
    execute("DELETE FROM event");
    execute("INSERT INTO event SELECT * FROM copy");
    execute("DROP TABLE copy");
  }
  for (const char* column : {"scans", "starts", "solutions", "finds", "failures", "checksum"}) {
    execute(fmt::format("UPDATE told SET {0}={0}+1", column));
    EXPECT_THROW(RunStore(folder(), example_identity(1)), base::Error) << column;
    execute(fmt::format("UPDATE told SET {0}={0}-1", column));
  }
  EXPECT_EQ(RunStore(folder(), example_identity(1)).told(), rounds(1, 3).reached);
  execute("UPDATE run SET value=1 WHERE key='format_version'");
  EXPECT_THAT(failure(), HasSubstr("run store has format 1"));
}

}  // namespace
}  // namespace sleight::store
