// Events of whole runs, both in their folders and at a listener.
#include "service/coordinator/run_events.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <variant>

#include "common/events/event_log.h"
#include "common/store/told_events.h"
#include "tests/unit/service/coordinator/ball_runs.h"

namespace sleight::coordinator {
namespace {

using ::testing::IsSupersetOf;

constexpr std::size_t k_all = 1'000'000;

class RunEventsOf : public testing::BallRuns {
 protected:
  std::string folder(const std::string& name) const { return run_folder(path(name)); }
  std::vector<events::RunEvent> told(const std::string& name) const {
    std::vector<events::RunEvent> events = store::events_told(folder(name), 1, k_all);
    std::erase_if(events, [](const events::RunEvent& event) { return event.number == 0; });
    for (std::size_t nth = 0; nth < events.size(); ++nth)
      EXPECT_EQ(events[nth].number, nth + 1);
    return events;
  }
  static std::vector<std::string> lines_of(const std::vector<events::RunEvent>& events) {
    std::vector<std::string> lines;
    for (const events::RunEvent& event : events)
      lines.push_back(events::to_line(event));
    return lines;
  }
  /// Returns the events without their numbers, and without the ends of sessions.
  static std::vector<std::string> without_ends(std::vector<events::RunEvent> events) {
    std::erase_if(events, [](const events::RunEvent& event) {
      return std::holds_alternative<events::RunEnd>(event.what);
    });
    for (events::RunEvent& event : events)
      event.number = 0;
    return lines_of(events);
  }
  template <class Kind>
  static std::vector<Kind> of_kind(const std::vector<events::RunEvent>& events) {
    std::vector<Kind> all;
    for (const events::RunEvent& event : events) {
      if (const auto* what = std::get_if<Kind>(&event.what)) all.push_back(*what);
    }
    return all;
  }
};

TEST_F(RunEventsOf, OneRunHaveTheirContents) {
  // Goal: a run reports each independent solution, each round and its end exactly once. Method:
  // compare the events of plain chains (no swaps) and ladders (swaps) with the runs' summaries.
  const RunSummary plain = session(request_text("scans = 200"), {.output = path("plain.h5")});
  const auto of_plain = told("plain.h5");
  const auto solutions = of_kind<events::Solution>(of_plain);
  ASSERT_EQ(solutions.size(), plain.progress.solutions);
  ASSERT_EQ(solutions.size(), 3U);
  for (std::size_t nth = 0; nth < solutions.size(); ++nth) {
    EXPECT_EQ(solutions[nth].nth, nth + 1);
    EXPECT_TRUE(solutions[nth].in_proportion);
    EXPECT_NE(solutions[nth].log_p, 0.0);
  }
  const auto rounds = of_kind<events::RoundEnded>(of_plain);
  ASSERT_EQ(rounds.size(), 3U);  // of 20, 40, 80 scans
  EXPECT_EQ(rounds[2], (events::RoundEnded{.chain = 0, .round = 3, .scans = 140}));
  const auto ends = of_kind<events::RunEnd>(of_plain);
  ASSERT_EQ(ends.size(), 1U);
  EXPECT_EQ(ends[0].digest, plain.digest);
  EXPECT_TRUE(std::holds_alternative<events::RunEnd>(of_plain.back().what));

  const RunSummary tempered = session(request_text("rounds = 3", {}, "parallel_tempering"),
                                      {.output = path("tempered.h5")}, 2);
  const auto of_ladders = told("tempered.h5");
  EXPECT_EQ(of_kind<events::Solution>(of_ladders).size(), tempered.progress.solutions);
  const auto ladder_rounds = of_kind<events::RoundEnded>(of_ladders);
  ASSERT_EQ(ladder_rounds.size(), 9U);
  std::uint64_t round_trips = 0;
  for (const events::RoundEnded& round : ladder_rounds) {
    EXPECT_GT(round.swaps.value(), 0.0);
    EXPECT_LE(round.swaps.value(), 1.0);
    round_trips += round.round_trips.value();
  }
  EXPECT_EQ(round_trips, tempered.progress.round_trips);
}

TEST_F(RunEventsOf, SessionsGoOnWithTheSameNumbers) {
  // Goal: even if a run is stopped, resumed, shortened and extended, it reports the events of an
  // uninterrupted run in the same order. Each session adds an event for its end. Reported events
  // keep their numbers. Method: compare the events of several sessions with the events of one
  // session.
  const std::string shorter = request_text("scans = 200", k_slow, "parallel_tempering");
  const std::string longer = request_text("scans = 320", k_slow, "parallel_tempering");
  (void)session(longer, {.output = path("at_once.h5")});
  std::vector<std::string> before;
  const auto expect_kept = [&] {
    const auto now = lines_of(told("parts.h5"));
    ASSERT_GE(now.size(), before.size());
    EXPECT_TRUE(std::equal(before.begin(), before.end(), now.begin()));
    before = now;
  };
  for (const std::uint64_t moment : {1U, 3U, 6U}) {
    (void)session(shorter, {.output = path("parts.h5"), .stop_requested = stop_at(moment)}, 2);
    expect_kept();
  }
  (void)session(shorter, {.output = path("parts.h5")}, 3);
  expect_kept();
  (void)session(request_text("scans = 50", k_slow, "parallel_tempering"),
                {.output = path("parts.h5")});
  expect_kept();
  (void)session(longer, {.output = path("parts.h5")}, 2);
  expect_kept();
  const auto parts = told("parts.h5");
  EXPECT_EQ(without_ends(parts), without_ends(told("at_once.h5")));
  const auto ends = of_kind<events::RunEnd>(parts);
  ASSERT_EQ(ends.size(), 6U);
  for (std::size_t nth = 0; nth < ends.size(); ++nth)
    EXPECT_EQ(ends[nth].epoch, nth + 1);
  EXPECT_EQ(ends[0].end, events::End::stop_requested);
}

TEST_F(RunEventsOf, ALogThatIsLostChangesNothing) {
  // Goal: if the event log is deleted or can't be written, no numbered event is lost and the run
  // doesn't end. Method: delete one run's log. Put a folder in the place of another run's log. Both
  // stores must have the same events. A later session must start a new log.
  const std::string request = request_text("scans = 150");
  (void)session(request, {.output = path("ball.h5")});
  const auto events = lines_of(told("ball.h5"));
  const std::string log = events::event_log_path(folder("ball.h5"));
  EXPECT_EQ(events::read_event_log(folder("ball.h5")).back().number, events.size());
  std::filesystem::remove(log);
  EXPECT_EQ(lines_of(told("ball.h5")), events);

  std::filesystem::create_directories(events::event_log_path(folder("other.h5")));
  EXPECT_EQ(session(request, {.output = path("other.h5")}).end, DriveEnd::finished);
  EXPECT_EQ(lines_of(told("other.h5")), events);

  (void)session(request, {.output = path("ball.h5")});
  const auto logged = events::read_event_log(folder("ball.h5"));
  ASSERT_FALSE(logged.empty());
  EXPECT_EQ(logged.back().number, events.size() + 1);
  EXPECT_EQ(told("ball.h5").size(), events.size() + 1);
}

TEST_F(RunEventsOf, ListenersHearAllInTheirThread) {
  // Goal: the listener gets each numbered event once and in order, and also progress, phases and
  // archives. The listener is called in the thread that runs the request. Method: compare the
  // numbered events with the events in the store.
  const auto here = std::this_thread::get_id();
  std::vector<events::RunEvent> heard;
  const auto hear = [&](const events::RunEvent& event) {
    EXPECT_EQ(std::this_thread::get_id(), here);
    heard.push_back(event);
  };
  (void)session(request_text("scans = 150"), {.output = path("ball.h5"), .hear = hear}, 3);
  const RunSummary second =
      session(request_text("scans = 300"), {.output = path("ball.h5"), .hear = hear}, 3);
  std::vector<events::RunEvent> numbered = heard;
  std::erase_if(numbered, [](const events::RunEvent& event) { return event.number == 0; });
  EXPECT_EQ(lines_of(numbered), lines_of(told("ball.h5")));
  const auto phases = of_kind<events::Phase>(heard);
  EXPECT_THAT(phases, IsSupersetOf({events::Phase{"reading results of earlier sessions"},
                                    events::Phase{"writing the archive"}}));
  EXPECT_EQ(of_kind<events::Progress>(heard).back().scans_done, 900U);
  const auto archives = of_kind<events::ArchiveWritten>(heard);
  ASSERT_FALSE(archives.empty());
  EXPECT_EQ(archives.back(), (events::ArchiveWritten{.digest = second.digest, .scans = 300}));
  const auto logged = events::read_event_log(folder("ball.h5"));
  EXPECT_EQ(of_kind<events::ArchiveWritten>(logged).back(), archives.back());
  EXPECT_EQ(of_kind<events::Progress>(logged).back().scans_done, 900U);
}

TEST_F(RunEventsOf, StartingOverForgetsThem) {
  // Goal: --fresh restarts numbering at 1 and reports no event of the deleted run. Method: run two
  // sessions. Then run a shorter request with --fresh to the same output.
  (void)session(request_text("scans = 150"), {.output = path("ball.h5")});
  (void)session(request_text("scans = 200"), {.output = path("ball.h5")});
  (void)session(request_text("scans = 100"), {.output = path("other.h5")});
  (void)session(request_text("scans = 100"), {.output = path("ball.h5"), .fresh = true});
  EXPECT_EQ(lines_of(told("ball.h5")), lines_of(told("other.h5")));
}

}  // namespace
}  // namespace sleight::coordinator
