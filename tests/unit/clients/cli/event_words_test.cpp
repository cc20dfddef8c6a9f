// Goal: events and changes of state read as words that say which and why, with nothing of them that
// a terminal would obey. Method: events of each kind, their words compared.
#include "clients/cli/event_words.h"

#include <gtest/gtest.h>

#include <string>

namespace sleight::cli {
namespace {

using events::RunEvent;

std::string words(RunEvent event) {
  return words_of_event({17}, event);
}

TEST(EventWords, EachKindIsALine) {
  // Goal: what happened in words, finds and solutions in proportion apart. Method: one of each
  // kind.
  EXPECT_EQ(
      words({.number = 1, .what = events::Solution{.nth = 2, .scan = 1760, .log_p = -12.345}}),
      "found 2: start 1,760, log p -12.35");
  EXPECT_EQ(
      words({.number = 2,
             .what =
                 events::Solution{
                     .nth = 3, .in_proportion = true, .chain = 2, .scan = 4000, .log_p = 0.5}}),
      "in proportion 3: chain 2, scan 4,000, log p 0.5");
  EXPECT_EQ(
      words({.number = 3,
             .what = events::Failure{.simulation = "work_limit",
                                     .chain = 1,
                                     .replica = 4,
                                     .scan = 9,
                                     .file = "failure-1-4-9.toml"}}),
      "simulation FAILED: work_limit, chain 1, replica 4, scan 9; `sleight fetch 17 --failures` "
      "brings what repeats it");
  EXPECT_EQ(
      words({.number = 4,
             .what =
                 events::RoundEnded{
                     .chain = 1, .round = 3, .scans = 7000, .swaps = 0.344, .round_trips = 12}}),
      "round 3 of chain 1 ended: 7,000 scans, 34% of swaps accepted, 12 round trips");
  EXPECT_EQ(words({.what = events::ArchiveWritten{.digest = "abc", .scans = 7000, .found = 5}}),
            "archive written: 5 found, 7,000 scans, digest abc");
  EXPECT_EQ(words({.number = 5,
                   .what =
                       events::RunEnd{
                           .epoch = 2, .end = events::End::failed, .words = "the disk is full"}}),
            "session 2 ended: failed. the disk is full");
  EXPECT_EQ(words({.what = events::Phase{"writing\x1b the archive"}}),
            "writing\\u{1b} the archive");
}

TEST(EventWords, AChangeSaysWhichStartAndWhy) {
  EXPECT_EQ(
      words_of_change(
          {.number = 2, .state = rpc::JobState::held, .reason = "the disk\nis full", .attempt = 3}),
      "held, start 3: the disk is full");
  EXPECT_EQ(words_of_change({.number = 1, .state = rpc::JobState::running, .attempt = 1}),
            "running");
}

}  // namespace
}  // namespace sleight::cli
