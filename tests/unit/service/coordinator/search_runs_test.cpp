// Goal: a run keeps the finds of a search. A search runs alone or before chains. The archive
// doesn't depend on threads or stops. Method: compare whole runs for a word with two bins.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/archive/digest/verify.h"
#include "common/archive/format.h"
#include "common/archive/hdf5/reader.h"
#include "common/archive/summary.h"
#include "tests/unit/service/coordinator/ball_runs.h"

namespace sleight::coordinator {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

// With sanitizers, sessions take ten times as long, so stops are rarer by this factor.
#ifdef SLEIGHT_SANITIZED
constexpr std::uint64_t k_rarer = 8;
#else
constexpr std::uint64_t k_rarer = 1;
#endif

class SearchRuns : public testing::BallRuns {
 protected:
  static std::string words(const std::string& sampler, const std::string& stop) {
    return "[world]\nname = \"spelling\"\nbitmap = \"\"\"\n.#.\n.#.\n\"\"\"\n[sampler]\nseed = "
           "5\n" +
           sampler + "[stop]\n" + stop;
  }
  static std::string search(int found) {
    return words("method = \"search\"\n", "found = " + std::to_string(found) + "\n");
  }
  static std::string islands(const std::string& stop) {
    return words(
        "method = \"sequential\"\nchains = 2\nparticles = 8\niterations_per_scan = 3\n"
        "round_scans = 4\n",
        stop);
  }
  static archive::Summary checked(const std::string& path) {
    const auto source = archive::hdf5::open_file(path);
    EXPECT_THAT(archive::verify(*source), IsEmpty());
    return archive::summary_of(*source);
  }
};

TEST_F(SearchRuns, FindTheSameWithAnyNumberOfThreads) {
  const RunSummary one = session(search(20), {.output = path("one.h5")});
  EXPECT_EQ(one.end, DriveEnd::finished);
  EXPECT_EQ(one.found, 20U);
  EXPECT_EQ(one.scans, 0U);
  for (const std::uint32_t threads : {2U, 5U}) {
    const std::string output = path(std::to_string(threads) + ".h5");
    EXPECT_EQ(session(search(20), {.output = output}, threads).digest, one.digest);
  }
  const archive::Summary summary = checked(path("one.h5"));
  EXPECT_EQ(summary.finds.found, 20U);
  EXPECT_EQ(summary.finds.animations, 20U);
  EXPECT_EQ(summary.scans, 0U);
  EXPECT_EQ(summary.animations, 0U);
  EXPECT_THAT(summary.warning, HasSubstr("not in the model's proportions"));
}

TEST_F(SearchRuns, GoOnAndAreCutShort) {
  // A request of more finds extends the run. A request of fewer finds shortens the archive. A
  // stopped run keeps its finds. Each archive equals that of an uninterrupted run with as many
  // finds.
  const std::string straight = session(search(12), {.output = path("s.h5")}).digest;
  const std::string shorter = session(search(3), {.output = path("t.h5")}).digest;
  EXPECT_EQ(session(search(3), {.output = path("a.h5")}).digest, shorter);
  EXPECT_EQ(session(search(12), {.output = path("a.h5")}).digest, straight);
  EXPECT_EQ(session(search(3), {.output = path("a.h5")}).digest, shorter);

  const RunSummary stopped =
      session(search(400), {.output = path("b.h5"), .stop_requested = stop_at(30)});
  EXPECT_EQ(stopped.end, DriveEnd::stop_requested);
  ASSERT_GT(stopped.found, 0U);
  EXPECT_LT(stopped.found, 400U);
  const archive::Summary summary = checked(path("b.h5"));
  EXPECT_THAT(summary.request_text,
              HasSubstr("[stop]\nfound = " + std::to_string(stopped.found) + "\n"));
  EXPECT_EQ(session(summary.request_text, {.output = path("c.h5")}).digest, stopped.digest);
  EXPECT_EQ(session(search(12), {.output = path("b.h5")}).digest, straight);
}

TEST_F(SearchRuns, TakesAreTheSame) {
  // Goal: takes are stored like finds and marked as relaxed. The archive doesn't depend on threads
  // or stops, and can be cut to fewer takes. The request in the archive reproduces the archive. If
  // a run is stopped before its first take, its archive contains the finds without relaxation.
  const auto takes = [](int count) {
    return words("method = \"search\"\nrelax_scans = 6\niterations_per_scan = 4\n",
                 "takes = " + std::to_string(count) + "\n");
  };
  const RunSummary straight = session(takes(8), {.output = path("s.h5")});
  EXPECT_EQ(straight.relaxed, 8U);
  EXPECT_EQ(straight.scans, 0U);
  const archive::Summary summary = checked(path("s.h5"));
  EXPECT_EQ(summary.finds.found, 8U);
  EXPECT_EQ(summary.finds.relax_scans, 6U);
  EXPECT_EQ(summary.finds.animations, 8U);
  EXPECT_EQ(summary.chains, 0U);
  EXPECT_THAT(summary.warning, HasSubstr("relaxed from a search: "));
  EXPECT_THAT(summary.request_text, HasSubstr("[stop]\ntakes = 8\n"));
  EXPECT_EQ(session(takes(8), {.output = path("t.h5")}, 3).digest, straight.digest);
  EXPECT_EQ(session(summary.request_text, {.output = path("again.h5")}).digest, straight.digest);

  // Stop the run often. Reproduce each archive from the request that it stores.
  RunSummary last{.end = DriveEnd::stop_requested};
  int sessions = 0;
  for (; last.end != DriveEnd::finished && sessions < 1000; ++sessions) {
    last = session(takes(8), {.output = path("p.h5"),
                              .stop_requested = stop_before_writing(20 * k_rarer, last)});
    if (last.digest.empty() || sessions % 4 != 0) continue;
    const archive::Summary cut = checked(path("p.h5"));
    const std::string file = path("cut" + std::to_string(sessions) + ".h5");
    EXPECT_EQ(session(cut.request_text, {.output = file}).digest, last.digest);
  }
  EXPECT_GT(sessions, 1);
  EXPECT_EQ(last.digest, straight.digest);
  EXPECT_EQ(session(takes(3), {.output = path("p.h5")}).digest,
            session(takes(3), {.output = path("few.h5")}).digest);

  // Stop before the first take.
  std::uint64_t found = 0;
  RunOptions options{.output = path("finds.h5")};
  options.hear = [&](const events::RunEvent& event) {
    if (const auto* progress = std::get_if<events::Progress>(&event.what))
      found = progress->finds.found;
  };
  options.stop_requested = [&] { return found == 3; };
  const RunSummary early =
      session(words("method = \"search\"\nrelax_scans = 1000000\n", "takes = 3\n"), options);
  EXPECT_EQ(early.relaxed, 0U);
  const archive::Summary finds = checked(path("finds.h5"));
  EXPECT_EQ(finds.finds.found, 3U);
  EXPECT_EQ(finds.finds.relax_scans, 0U);
  EXPECT_EQ(session(finds.request_text, {.output = path("same.h5")}).digest, early.digest);
}

TEST_F(SearchRuns, StandBeforeChains) {
  // An archive contains a search's finds in addition to the chains' draws. The finds don't change
  // the draws.
  const RunSummary both =
      session(islands("scans = 12\nfound = 4\n"), {.output = path("both.h5")}, 2);
  EXPECT_EQ(both.found, 4U);
  EXPECT_EQ(both.scans, 12U);
  const archive::Summary summary = checked(path("both.h5"));
  EXPECT_EQ(summary.finds.animations, 4U);
  EXPECT_EQ(summary.scans, 8U);  // one round of 4 scans is burn-in
  EXPECT_EQ(summary.warning, "");
  EXPECT_THAT(summary.request_text, HasSubstr("[stop]\nscans = 12\nfound = 4\n"));
  const RunSummary again = session(summary.request_text, {.output = path("again.h5")});
  EXPECT_EQ(again.digest, both.digest);

  const RunSummary alone = session(islands("scans = 12\n"), {.output = path("alone.h5")});
  EXPECT_EQ(alone.found, 0U);
  const auto with = archive::hdf5::open_file(path("both.h5"));
  const auto without = archive::hdf5::open_file(path("alone.h5"));
  EXPECT_EQ(archive::find_group(*without, archive::k_finds), nullptr);
  for (const char* dataset : {"lp", "filled", "log_prior"}) {
    EXPECT_EQ(with->read(archive::k_sample_stats, dataset, 0, 16),
              without->read(archive::k_sample_stats, dataset, 0, 16));
  }
}

TEST_F(SearchRuns, IslandsThatTellTheOddsAreTheSame) {
  // Goal: the islands that determine the odds don't depend on threads or stops, and the archive's
  // request reproduces them.
  const std::string request = words("", "odds = 1.0\n");
  const RunSummary straight = session(request, {.output = path("s.h5")});
  ASSERT_EQ(straight.end, DriveEnd::finished);
  EXPECT_EQ(session(request, {.output = path("t.h5")}, 3).digest, straight.digest);
  RunSummary last{.end = DriveEnd::stop_requested};
  int sessions = 0;
  for (; last.end != DriveEnd::finished && sessions < 1000; ++sessions)
    last = session(request, {.output = path("p.h5"),
                             .stop_requested = stop_before_writing(20 * k_rarer, last)});
  EXPECT_GT(sessions, 1);  // the run was stopped
  EXPECT_EQ(last.digest, straight.digest);
  const std::string again = checked(path("s.h5")).request_text;
  EXPECT_EQ(session(again, {.output = path("again.h5")}).digest, straight.digest);

  // The odds exclude the pilot's islands.
  const auto source = archive::hdf5::open_file(path("s.h5"));
  const archive::Values from = source->read(archive::k_tempering, "odds_from_island", 0, 1);
  EXPECT_EQ(std::get<std::vector<double>>(from).at(0), 32);
}

TEST_F(SearchRuns, AreKeptWhenChainsHaveNoDrawsYet) {
  // Goal: if a run is stopped during the chains' burn-in, its archive contains the search's finds.
  const std::string endless = words(
      "method = \"sequential\"\nchains = 2\nparticles = 8\nround_scans = 1000\n"
      "iterations_per_scan = 100\n",
      "independent_solutions = 2\nfound = 3\n");
  std::uint64_t found = 0;
  RunOptions options{.output = path("cut.h5")};
  options.hear = [&](const events::RunEvent& event) {
    if (const auto* progress = std::get_if<events::Progress>(&event.what))
      found = progress->finds.found;
  };
  options.stop_requested = [&] { return found == 3; };
  const RunSummary stopped = session(endless, options);
  EXPECT_EQ(stopped.end, DriveEnd::stop_requested);
  EXPECT_THAT(stopped.digest, Not(IsEmpty()));
  const archive::Summary summary = checked(path("cut.h5"));
  EXPECT_EQ(summary.finds.found, 3U);
  EXPECT_EQ(summary.scans, 0U);
}

TEST_F(SearchRuns, JudgedChainsGiveTheSameBits) {
  // Goal: if chains start from a search, the archive doesn't depend on threads or stops. The
  // archive's draws begin with the judged scans. Each chain's counted scan is its first kept
  // animation. Method: compare a run of three threads, a run of several sessions, and a run of the
  // archive's request.
  const auto judged = [](const std::string& stop) {
    return words(
        "method = \"metropolis_hastings\"\nstart = \"search\"\nchains = 4\nround_scans = 8\n"
        "iterations_per_scan = 4\naim_ball = 0.2\nscatter_ball = 0.2\nchange_ball = 0.1\n"
        "change_vertices = 0.14\nvertex_redraw = 1.0\n",
        stop);
  };
  const std::string four = judged("independent_solutions = 4\nfound = 2\n");
  const RunSummary straight = session(four, {.output = path("s.h5")});
  ASSERT_EQ(straight.end, DriveEnd::finished);
  EXPECT_GE(straight.progress.solutions, 4U);
  EXPECT_EQ(session(four, {.output = path("t.h5")}, 3).digest, straight.digest);
  RunSummary last{.end = DriveEnd::stop_requested};
  int sessions = 0;
  for (; last.end != DriveEnd::finished && sessions < 1000; ++sessions)
    last = session(
        four, {.output = path("p.h5"), .stop_requested = stop_before_writing(40 * k_rarer, last)});
  EXPECT_GT(sessions, 1);
  EXPECT_EQ(last.digest, straight.digest);
  const archive::Summary summary = checked(path("s.h5"));
  EXPECT_LT(summary.scans, straight.scans);
  EXPECT_GE(summary.animations, 4U);
  EXPECT_EQ(session(summary.request_text, {.output = path("cut.h5")}).digest, straight.digest);

  const auto source = archive::hdf5::open_file(path("s.h5"));
  const auto counted =
      std::get<std::vector<double>>(source->read(archive::k_tempering, "counted_scan", 0, 4));
  const auto begin =
      std::get<std::vector<double>>(source->read(archive::k_tempering, "tour_judged_from", 0, 1));
  const auto drawn = std::get<std::vector<std::int64_t>>(
      source->read(archive::k_animations, "draw", 0, summary.animations));
  const auto of_chain = std::get<std::vector<std::int64_t>>(
      source->read(archive::k_animations, "chain", 0, summary.animations));
  for (std::size_t chain = 0; chain < 4; ++chain) {
    if (std::isnan(counted[chain])) continue;
    std::int64_t first = -1;
    for (std::size_t i = 0; i < drawn.size() && first < 0; ++i)
      if (of_chain[i] == static_cast<std::int64_t>(chain)) first = drawn[i];
    EXPECT_EQ(static_cast<double>(first), counted[chain] - begin[0]) << chain;
  }

  const RunSummary more =
      session(judged("independent_solutions = 8\nfound = 2\n"), {.output = path("s.h5")});
  EXPECT_GE(more.progress.solutions, 8U);
  EXPECT_GT(more.scans, straight.scans);
  EXPECT_EQ(session(four, {.output = path("s.h5")}).digest, straight.digest);
}

}  // namespace
}  // namespace sleight::coordinator
