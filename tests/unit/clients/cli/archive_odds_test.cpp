// Goal: an archive's odds have an interval where its ladders can be trusted; else people and
// machines are told that they are unknown, why, and which key makes them known. Method: made-up
// tables of /tempering in the memory twin.
#include "clients/cli/archive_odds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/archive/format.h"
#include "common/archive/memory_archive.h"
#include "common/base/error.h"
#include "common/request/direction_request.h"

namespace sleight::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double k_infinity = std::numeric_limits<double>::infinity();

/// Ladders that all say the same, round by round.
struct Tables {
  std::uint64_t chains = 4;
  std::vector<double> scans{64, 128, 256};
  std::vector<double> log_p{-4.9, -4.8, -4.8};
  double error = 0.1;
  double round_trips = 20;
  double allowed_round_trips = 30;  ///< in the last round, by swaps alone
  double log_natural_throw = 0;
  std::string world = "ball_2d";
  std::string method = "parallel_tempering";
  std::string sampler_keys = "round_scans = 64\n";
};

struct Made {
  archive::MemoryArchive source;
  archive::Summary summary;
};

Made archive_of(const Tables& tables) {
  Made made;
  const std::size_t rounds = tables.scans.size();
  made.source.create_group(archive::k_tempering);
  made.source.set_attribute(archive::k_tempering, {"log_natural_throw", tables.log_natural_throw});
  const auto table = [&](const char* name, const auto& value) {
    std::vector<double> values;
    for (std::uint64_t c = 0; c < tables.chains; ++c) {
      for (std::size_t r = 0; r < rounds; ++r)
        values.push_back(value(r));
    }
    const auto handle = made.source.create_dataset(
        archive::k_tempering,
        {.name = name, .dims = {{"chain", tables.chains}, {"round", rounds}}});
    made.source.append(handle, std::span<const double>(values));
  };
  double first = 0;
  std::vector<double> first_scans;
  for (const double scans : tables.scans) {
    first_scans.push_back(first);
    first += scans;
  }
  table("first_scan", [&](std::size_t r) { return first_scans[r]; });
  table("scans", [&](std::size_t r) { return tables.scans[r]; });
  table("round_trips", [&](std::size_t) { return tables.round_trips; });
  table("predicted_round_trip_rate",
        [&](std::size_t) { return tables.allowed_round_trips / tables.scans.back(); });
  for (const std::string name : {"log_z", "log_p_satisfied"}) {
    table(name.c_str(), [&](std::size_t r) { return tables.log_p[r]; });
    table((name + "_error").c_str(), [&](std::size_t) { return tables.error; });
  }
  made.summary.world = tables.world;
  made.summary.request_text =
      "[sampler]\nmethod = \"" + tables.method + "\"\n" + tables.sampler_keys;
  made.summary.chains = tables.chains;
  made.summary.scans = static_cast<std::uint64_t>(first);
  return made;
}

std::string words(const Tables& tables) {
  const Made made = archive_of(tables);
  return in_words(odds_of(made.source, made.summary).value());
}

nlohmann::ordered_json json(const Tables& tables) {
  const Made made = archive_of(tables);
  return as_json(odds_of(made.source, made.summary).value());
}

TEST(ArchiveOdds, GoodLaddersHaveAnInterval) {
  EXPECT_EQ(words({}),
            "  log Z        -4.80 +- 0.05 (4 ladders, jackknife within ladders), round 3 of 3\n"
            "  by chance    one throw in 122 (116 to 128)\n"
            "               log P -4.80 +- 0.05 (4 ladders, jackknife within ladders), "
            "round 3 of 3\n");
  const nlohmann::ordered_json said = json({});
  EXPECT_EQ(said["known"], true);
  EXPECT_NEAR(said["log10_throws_low"].get<double>(), 4.75 / std::log(10), 1e-9);
  EXPECT_NEAR(said["log_p_satisfied"]["error"].get<double>(), 0.05, 1e-12);
  EXPECT_TRUE(said["log_p_satisfied"]["doubts"].empty());
  EXPECT_TRUE(said["to_know"].is_null());
}

TEST(ArchiveOdds, WithoutRoundTripsTheyAreUnknown) {
  Tables tables;
  tables.round_trips = 0;
  EXPECT_EQ(words(tables),
            "  log Z        -4.80, error unknown (4 ladders), round 3 of 3\n"
            "  by chance    unknown\n"
            "               4 of 4 ladders made no round trip in round 3 of 3: each has to make 5\n"
            "               to know it: at least rounds = 9 under [stop] (32704 scans of each "
            "ladder)\n"
            "               more iterations_per_scan helps too: swaps alone would allow 30 round "
            "trips\n"
            "               so far log P -4.80, error unknown (4 ladders), round 3 of 3\n"
            "               which mostly is too low while ladders have not mixed\n");
  const nlohmann::ordered_json said = json(tables);
  EXPECT_EQ(said["known"], false);
  EXPECT_EQ(said["ladders_without_round_trip"], 4);
  EXPECT_EQ(said["log_p_satisfied"]["value"], -4.8);
  for (const char* name : {"log10_throws", "log10_throws_low", "log10_throws_high"})
    EXPECT_TRUE(std::isnan(said[name].get<double>()));
  EXPECT_TRUE(said["log_p_satisfied"]["error"].is_null());
  EXPECT_TRUE(said["log_z"]["error"].is_null());
  EXPECT_EQ(said["to_know"]["rounds"], 9);
  EXPECT_EQ(said["to_know"]["scans"], 32704);
  EXPECT_EQ(said["to_know"]["at_least"], true);
}

TEST(ArchiveOdds, KeysThatHelpDependOnWhatIsSlow) {
  Tables tables;
  tables.round_trips = 2;
  // Eight round trips of 40: five times 256 scans, which the sixth round has (2,048).
  EXPECT_THAT(words(tables), HasSubstr("to know it: rounds = 6 under [stop] (4032 scans"));
  tables.allowed_round_trips = 3;
  EXPECT_THAT(words(tables), Not(HasSubstr("iterations_per_scan")));
  // Their number is chosen from the barrier unless the request says it.
  EXPECT_THAT(words(tables), Not(HasSubstr("replicas")));
  tables.sampler_keys += "replicas = 4\n";
  EXPECT_THAT(words(tables),
              HasSubstr("more replicas under [sampler] help too: swaps alone allow only 3.0"));
  tables.method = "simulated_tempering";
  EXPECT_THAT(words(tables), HasSubstr("to know it: burn_in_rounds = 6 under [sampler]"));
  EXPECT_THAT(words(tables), HasSubstr("round 3 of 3 of the burn-in"));
}

TEST(ArchiveOdds, ASingleRoundNeedsASecondOne) {
  Tables tables;
  tables.scans = {64};
  tables.log_p = {-4.8};
  EXPECT_THAT(words(tables), HasSubstr("to know it: rounds = 2 under [stop] (192 scans"));
  // Also where it was cut off.
  tables.scans = {20};
  EXPECT_THAT(words(tables), HasSubstr("to know it: rounds = 2 under [stop] (192 scans"));
}

TEST(ArchiveOdds, ThrowsThatAreNoDrawsAreNamed) {
  // Of a word of three balls: draws satisfy once in e^6.88, throws of all balls 8 times as often.
  Tables tables;
  tables.world = "spelling";
  tables.log_natural_throw = 3 * std::log(0.5);
  tables.log_p = {-6.88, -6.88, -6.88};
  EXPECT_THAT(words(tables),
              HasSubstr("  by chance    one throw in 122 (116 to 128), where a throw leaves no "
                        "body out\n               log P -4.80 +- 0.05 ("));
  const nlohmann::ordered_json said = json(tables);
  EXPECT_NEAR(said["log_p_satisfied"]["value"].get<double>(), -6.88, 1e-12);
  EXPECT_NEAR(said["log_p_throw"]["value"].get<double>(), -4.80, 1e-3);
  EXPECT_EQ(said["natural_throw"], "a throw leaves no body out");
  tables.round_trips = 0;
  EXPECT_THAT(words(tables), HasSubstr("so far log P -4.80, error unknown (4 ladders), "
                                       "round 3 of 3, where a throw leaves no body out\n"));
  tables.log_natural_throw = 1;
  EXPECT_THAT(words(tables), HasSubstr("a throw's bodies are numbered before it"));
}

TEST(ArchiveOdds, WhatNeverSatisfiedIsUnknown) {
  Tables tables;
  tables.log_p = {-4.8, -4.8, -k_infinity};
  std::string text = words(tables);
  EXPECT_THAT(text, HasSubstr("nothing satisfied in 4 of 4 ladders in round 3 of 3\n"));
  EXPECT_THAT(text, HasSubstr("so far log P -4.80, error unknown (4 ladders), round 2 of 3\n"));
  tables.log_p.assign(3, -k_infinity);
  text = words(tables);
  EXPECT_THAT(text, HasSubstr("by chance    unknown: nothing satisfied in any round\n"));
  EXPECT_THAT(text, HasSubstr("to know it: at least rounds = 4 under [stop]"));
  EXPECT_THAT(text, Not(HasSubstr("so far log P")));
}

/// Islands of chains; of each three the first is larger than the others.
struct IslandTables {
  std::uint64_t chains = 4;
  std::uint64_t islands = 60;
  double log_p = -4.8;              ///< of the first ones
  double log_low = std::log(0.25);  ///< of the others, to that
  std::vector<double> odds_from{};  ///< by chain; empty: no such table
  std::string sampler{};
  std::string stop = "scans = 20\n";
  std::vector<double> values{};  ///< if not empty, all of log P
};

Made islands_archive(const IslandTables& tables) {
  Made made;
  made.source.create_group(archive::k_tempering);
  made.source.set_attribute(archive::k_tempering, {"log_natural_throw", 0.0});
  const auto table = [&](const char* name, std::vector<archive::Dimension> dims,
                         const std::vector<double>& values) {
    const auto handle =
        made.source.create_dataset(archive::k_tempering, {.name = name, .dims = std::move(dims)});
    made.source.append(handle, std::span<const double>(values));
  };
  std::vector<double> values = tables.values;
  for (std::uint64_t i = 0; tables.values.empty() && i < tables.chains * tables.islands; ++i)
    values.push_back(tables.log_p + (i % 3 == 0 ? 0 : tables.log_low));
  const std::vector<archive::Dimension> dims{{"chain", tables.chains}, {"island", tables.islands}};
  table("island_log_z", dims, values);
  table("island_log_satisfied", dims, values);
  if (!tables.odds_from.empty())
    table("odds_from_island", {{"chain", tables.odds_from.size()}}, tables.odds_from);
  made.summary.world = "ball_2d";
  made.summary.request_text =
      "[sampler]\nmethod = \"sequential\"\n" + tables.sampler + "[stop]\n" + tables.stop;
  made.summary.chains = tables.chains;
  made.summary.scans = 20;
  return made;
}

std::string words_of(const IslandTables& tables) {
  const Made made = islands_archive(tables);
  return in_words(odds_of(made.source, made.summary).value());
}

nlohmann::ordered_json json_of(const IslandTables& tables) {
  const Made made = islands_archive(tables);
  return as_json(odds_of(made.source, made.summary).value());
}

TEST(ArchiveOdds, IslandsOfAFixedNumberAllCount) {
  // Of each three one is 1 and two are 1/4: mean 1/2, relative variance 1/2 (times 240 / 239).
  const double log_p = -4.8 + std::log(0.5);
  const double error = std::sqrt(0.5 / 239);
  const nlohmann::ordered_json said = json_of(IslandTables{});
  EXPECT_EQ(said["from"], "islands");
  EXPECT_EQ(said["known"], true);
  EXPECT_EQ(said["log_p_satisfied"]["islands"], 240);
  EXPECT_NEAR(said["log_p_satisfied"]["value"].get<double>(), log_p, 1e-9);
  EXPECT_NEAR(said["log_p_satisfied"]["error"].get<double>(), error, 1e-9);
  EXPECT_EQ(said["log_p_satisfied"]["error_from"], "spread of islands");
  EXPECT_NEAR(said["log10_throws_high"].get<double>(), (error - log_p) / std::log(10), 1e-9);
  EXPECT_FALSE(said.contains("rounds"));
  EXPECT_FALSE(said.contains("odds_from_island"));
  EXPECT_FALSE(said["log_z"].contains("round"));
  EXPECT_TRUE(said["to_know"].is_null());
  EXPECT_THAT(words_of(IslandTables{}),
              HasSubstr("               log P -5.49 +- 0.05 (240 islands, spread of islands)\n"));
}

TEST(ArchiveOdds, OfASizedRoundTheLastIslandsCount) {
  // Those before, a third of which would carry the sum, don't. Method: the first 20 of each chain
  // are e^9 times as large.
  IslandTables tables;
  for (std::uint64_t i = 0; i < tables.chains * tables.islands; ++i)
    tables.values.push_back((i % tables.islands < 20 ? 9 : 0) + (i % 3 == 0 ? -4.8 : -5.8));
  tables.odds_from.assign(4, 20);
  tables.stop = "scans = 20\nodds = 0.1\n";
  const nlohmann::ordered_json said = json_of(tables);
  EXPECT_EQ(said["known"], true);
  EXPECT_EQ(said["odds_from_island"], 20);
  EXPECT_EQ(said["log_p_satisfied"]["islands"], 160);
  EXPECT_LT(said["log_p_satisfied"]["value"].get<double>(), -4.8);
}

TEST(ArchiveOdds, IslandsThatChoseTheirNumberAreUnknown) {
  IslandTables tables;
  tables.stop = "scans = 20\nindependent_solutions = 2\n";
  std::string text = words_of(tables);
  EXPECT_THAT(text, HasSubstr("  by chance    unknown\n"
                              "               the run could end by solutions, so islands "
                              "themselves chose how many they are\n"
                              "               to know it: odds = 0.1 under [stop], in place of "
                              "other rules\n"
                              "               so far log P -5.49, error unknown (240 islands)\n"
                              "               which hangs on when the run ended\n"));
  tables.stop = "scans = 20\nodds = 0.3\n";
  text = words_of(tables);
  EXPECT_THAT(text, HasSubstr("the last round, whose islands alone tell the odds, is not sized"));
  EXPECT_THAT(text, HasSubstr("odds = 0.3 under [stop]"));
  EXPECT_EQ(json_of(tables)["to_know"]["odds"], 0.3);
  // A number that no request has is not repeated.
  tables.stop = "scans = 20\nodds = 7.0\n";
  EXPECT_THAT(words_of(tables), HasSubstr("odds = 0.1 under [stop]"));
  Made made = islands_archive(IslandTables{});
  made.summary.request_text = "= no request";
  EXPECT_THAT(in_words(odds_of(made.source, made.summary).value()),
              HasSubstr("its request does not say what chose the number of islands"));
}

TEST(ArchiveOdds, OneLargeIslandMakesThemUnknown) {
  // A sized round whose largest island has 4 tenths: four times as many islands, half the error.
  IslandTables tables;
  tables.values.assign(240, -210);
  tables.values[100] = -210 + std::log(160);
  tables.odds_from.assign(4, 0);
  tables.stop = "scans = 20\nodds = 0.1\n";
  const std::string text = words_of(tables);
  EXPECT_THAT(text, HasSubstr("one of 240 islands has 40.1% of the sum, and may have 10%\n"
                              "               to know it: odds = 0.049 under [stop], in place of "
                              "other rules\n"
                              "               more particles under [sampler] make islands more "
                              "equal\n"));
  EXPECT_THAT(text, HasSubstr("which mostly is too low where few islands have most of the sum"));
}

TEST(ArchiveOdds, WhatIsAdvisedSizesALongerRound) {
  // Goal: who asks for the error that is advised gets more islands than he has. Method: a round of
  // 160 islands with a heavy tail, sized by 80 of which a third is larger: they foretold sqrt(0.5 *
  // 80 / 79 / 160) = 0.0563, so that any error from there on sizes the same round. Nine tenths of
  // it, and not a digit more.
  IslandTables tables;
  for (std::uint64_t i = 0; i < tables.chains * tables.islands; ++i) {
    const bool is_large = i % tables.islands < 20 ? (i / 60 * 20 + i % 60) % 3 == 0 : i == 30;
    tables.values.push_back(is_large ? -4.8 : -4.8 + std::log(0.25));
  }
  tables.values[30] = 1;
  tables.odds_from.assign(4, 20);
  tables.stop = "scans = 20\nodds = 0.3\n";
  EXPECT_THAT(words_of(tables), HasSubstr("to know it: odds = 0.05 under [stop]"));
  EXPECT_LT(json_of(tables)["to_know"]["odds"].get<double>(), 0.9 * 0.0564);
}

TEST(ArchiveOdds, WhatIsAdvisedCanBeAskedFor) {
  // Goal: no NaN and nothing below the range. Method: a heavy tail after equal islands, which
  // foretell an error of 0; one after islands none of which satisfies, which foretell nothing.
  IslandTables tables;
  tables.odds_from.assign(4, 20);
  tables.stop = "scans = 20\nodds = 0.3\n";
  tables.values.assign(240, -210);
  tables.values[100] = -200;
  EXPECT_EQ(json_of(tables)["to_know"]["odds"], request::k_odds_min);
  for (std::size_t i = 0; i < tables.values.size(); ++i)
    if (i % 60 < 20) tables.values[i] = -k_infinity;
  const double advised = json_of(tables)["to_know"]["odds"];
  EXPECT_GT(advised, request::k_odds_min);
  EXPECT_LT(advised, 0.3);
}

TEST(ArchiveOdds, ToursHaveToGoForOdds) {
  // Goal: what is advised is a request, and all of it is said. Method: the default of short words,
  // and islands of too few particles.
  IslandTables tables;
  tables.sampler = "tour_scans = 16\n";
  tables.stop = "independent_solutions = 2\n";
  const std::string advised =
      "to know it: odds = 0.1 under [stop], in place of other rules\n"
      "               without tour_scans under [sampler]";
  EXPECT_THAT(words_of(tables), HasSubstr(advised + "\n"));
  tables.sampler += "particles = 2\n";
  EXPECT_THAT(words_of(tables), HasSubstr(advised + "; more particles under [sampler] make"));
}

TEST(ArchiveOdds, IslandsKnowOddsThatNoDoubleHolds) {
  IslandTables tables;
  tables.log_p = -90 * std::log(10);
  tables.log_low = 0;
  EXPECT_THAT(words_of(tables), HasSubstr("  by chance    one throw in 1.000e90 (1.000e90 to "
                                          "1.000e90)\n"));
  tables.log_p = -k_infinity;
  EXPECT_THAT(words_of(tables),
              HasSubstr("by chance    unknown: nothing satisfied in any island\n"));
}

TEST(ArchiveOdds, IslandsThatCannotBeAreRefused) {
  // Goal: what no run writes is a bad archive, not a crash. Method: numbers that are no logs of
  // estimates, other numbers of chains, islands that are not there.
  const auto expect_refused = [](const IslandTables& tables, const char* what) {
    const Made made = islands_archive(tables);
    EXPECT_THROW(odds_of(made.source, made.summary), base::Error) << what;
  };
  for (const double bad : {k_infinity, std::numeric_limits<double>::quiet_NaN()}) {
    IslandTables tables;
    tables.values.assign(240, -5);
    tables.values[77] = bad;
    expect_refused(tables, "values");
  }
  for (const std::vector<double>& from :
       {std::vector<double>(3, 0), std::vector<double>{0, 0, 0, 1}, std::vector<double>(4, 61),
        std::vector<double>(4, -1), std::vector<double>(4, 0.5),
        std::vector<double>(4, std::numeric_limits<double>::quiet_NaN())}) {
    IslandTables tables;
    tables.odds_from = from;
    expect_refused(tables, "odds_from_island");
  }
  Made made = islands_archive(IslandTables{});
  made.summary.chains = 5;
  EXPECT_THROW(odds_of(made.source, made.summary), base::Error);
  // A last round without islands is told as one.
  IslandTables none;
  none.odds_from.assign(4, 60);
  EXPECT_THAT(words_of(none), HasSubstr("none of 0 islands has a value above 0"));
}

TEST(ArchiveOdds, ARequestThatCannotBeReadIsNoMatter) {
  Tables tables;
  tables.round_trips = 0;
  Made made = archive_of(tables);
  made.summary.request_text = "= no request";
  EXPECT_THAT(in_words(odds_of(made.source, made.summary).value()),
              HasSubstr("to know it: at least 40.0 times as many scans"));
}

}  // namespace
}  // namespace sleight::cli
