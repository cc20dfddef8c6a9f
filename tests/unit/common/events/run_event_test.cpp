#include "common/events/run_event.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace sleight::events {
namespace {

std::vector<RunEvent> examples() {
  Progress progress{
      .scans_done = 5,
      .scans_total = 9,
      .finds = {.found = 2, .wanted = 3, .gave_up_because = "ball \"3\"", .is_all = true},
      .found_s = 0.25,
      .failures = {.by_kind = {1, 0, 0, 2, 0, 0}},
      .workers = 4,
      .elapsed_s = 12.5};
  Progress with_trips = progress;
  with_trips.round_trips = 7;
  return {
      {.what = Phase{.words = "writing the archive"}},
      {.what = progress},
      {.what = with_trips},
      {.number = 1,
       .what =
           Solution{.nth = 3, .in_proportion = true, .chain = 2, .scan = 1U << 31U, .log_p = -0.1}},
      {.number = 2,
       .what =
           Failure{.simulation = "work_limit", .chain = 1, .replica = 3, .scan = 9, .file = "a"}},
      {.number = 3, .what = RoundEnded{.chain = 1, .round = 2, .scans = 64}},
      {.number = 4,
       .what = RoundEnded{.chain = 1, .round = 3, .scans = 128, .swaps = 0.375, .round_trips = 0}},
      {.what = ArchiveWritten{.digest = "00ff", .scans = 128, .found = 2}},
      {.number = 5,
       .what = RunEnd{.epoch = 2,
                      .end = End::failed,
                      .exit_code = base::ExitCode::environment,
                      .words = "disk\nfull"}}};
}

TEST(RunEvent, ComesBackFromItsLine) {
  // Goal: each kind of event is written as one line, and the line reads back with every field.
  // Method: write an example of each kind, read its line, and write the event again. Both lines
  // must be equal.
  for (const RunEvent& event : examples()) {
    const std::string line = to_line(event);
    EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1) << line;
    EXPECT_TRUE(line.starts_with("{\"number\":" + std::to_string(event.number) + ",\"kind\":\"" +
                                 std::string(kind_of(event)) + "\""))
        << line;
    const auto back = run_event_of(line);
    ASSERT_TRUE(back.has_value()) << line;
    EXPECT_EQ(back->what.index(), event.what.index());
    EXPECT_EQ(to_line(*back), line);
  }
  EXPECT_EQ(to_line(examples()[3]),
            "{\"number\":1,\"kind\":\"solution\",\"nth\":3,\"in_proportion\":true,\"chain\":2,"
            "\"scan\":2147483648,\"log_p\":-0.1}\n");
}

TEST(RunEvent, NothingElseIsOne) {
  // Goal: a damaged line is refused or reads as a different event. Method: change each byte of a
  // line in turn. Cut the line at each byte. Use lines with missing fields, wrong types and numbers
  // out of range.
  for (const RunEvent& event : examples()) {
    const std::string line = to_line(event);
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      EXPECT_FALSE(run_event_of(line.substr(0, i)).has_value()) << line.substr(0, i);
      std::string other = line;
      other[i] = other[i] == 'z' ? 'y' : 'z';
      const auto read = run_event_of(other);
      if (read) {
        EXPECT_NE(to_line(*read), line) << other;
      }
    }
  }
  for (const char* line :
       {"", "{}", "[]", "{\"kind\":3}", "{\"number\":1,\"kind\":\"phase\"}",
        "{\"number\":-1,\"kind\":\"phase\",\"words\":\"x\"}",
        "{\"number\":1,\"kind\":\"phrase\",\"words\":\"x\"}",
        "{\"number\":1,\"kind\":\"solution\",\"nth\":1,\"in_proportion\":1,\"chain\":0,\"scan\":1,"
        "\"log_p\":0}",
        "{\"number\":1,\"kind\":\"solution\",\"nth\":1,\"in_proportion\":true,\"chain\":4294967296,"
        "\"scan\":1,\"log_p\":0}",
        "{\"number\":1,\"kind\":\"ended\"}", "{\"number\":1,\"kind\":\"ended\",\"end\":{}}"})
    EXPECT_FALSE(run_event_of(line).has_value()) << line;
}

}  // namespace
}  // namespace sleight::events
