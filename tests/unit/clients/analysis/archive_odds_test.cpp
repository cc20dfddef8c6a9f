// Goal: an archive's odds have an interval if its ladders can be trusted. Otherwise the odds are
// unknown, and the answer names a request key and a value that would make the odds known. Method:
// make up the tables of /tempering in an in-memory archive.
#include "clients/analysis/archive_odds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/archive/format.h"
#include "common/base/error.h"
#include "common/json/value.h"
#include "common/request/direction_request.h"
#include "tests/archive/memory_archive.h"
#include "tests/support/numbers.h"

namespace sleight::analysis {
namespace {

using ::testing::HasSubstr;

/// Made-up tables of /tempering. All ladders have the same estimate in a round.
struct Tables {
  std::uint64_t chains = 4;
  std::vector<double> scans{64, 128, 256};
  std::vector<double> log_p{-4.9, -4.8, -4.8};
  double error = 0.1;
  double round_trips = 20;
  double allowed_round_trips = 30;  ///< in the last round, from swaps alone
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

json::Value json(const Tables& tables) {
  const Made made = archive_of(tables);
  return as_json(odds_of(made.source, made.summary).value());
}

TEST(ArchiveOdds, GoodLaddersHaveAnInterval) {
  const json::Value said = json({});
  EXPECT_EQ(said["known"], true);
  EXPECT_NEAR(said["log10_throws_low"].get<double>(), 4.75 / std::log(10), 1e-9);
  EXPECT_NEAR(said["log_p_satisfied"]["error"].get<double>(), 0.05, 1e-12);
  EXPECT_TRUE(said["log_p_satisfied"]["doubts"].empty());
  EXPECT_TRUE(said["to_know"].is_null());
}

TEST(ArchiveOdds, WithoutRoundTripsTheyAreUnknown) {
  Tables tables;
  tables.round_trips = 0;
  const json::Value said = json(tables);
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
  const auto besides = [&] {
    const Made made = archive_of(tables);
    return odds_of(made.source, made.summary).value().how_to_know.value().besides;
  };
  // The last round (256 scans) has 8 of the 40 required round trips, so a round needs 5 * 256
  // scans. The sixth round (2,048 scans) is the first that is long enough.
  EXPECT_EQ(json(tables)["to_know"]["rounds"], 6);
  EXPECT_EQ(json(tables)["to_know"]["scans"], 4032);
  EXPECT_THAT(besides(), HasSubstr("iterations_per_scan"));
  tables.allowed_round_trips = 3;
  // The barrier determines the number of replicas unless the request sets it.
  EXPECT_EQ(besides(), "");
  tables.sampler_keys += "replicas = 4\n";
  EXPECT_THAT(besides(), HasSubstr("replicas"));
  tables.method = "simulated_tempering";
  EXPECT_EQ(json(tables)["from"], "burn_in");
  EXPECT_EQ(json(tables)["to_know"]["rounds"], 6);
}

TEST(ArchiveOdds, ASingleRoundNeedsASecondOne) {
  Tables tables;
  tables.log_p = {-4.8};
  // The advice stays the same if the first round was cut off.
  for (const double scans : {64.0, 20.0}) {
    tables.scans = {scans};
    EXPECT_EQ(json(tables)["to_know"]["rounds"], 2);
    EXPECT_EQ(json(tables)["to_know"]["scans"], 192);
  }
}

TEST(ArchiveOdds, ThrowsThatAreNoDrawsAreNamed) {
  // For a word of three balls, one draw in e^6.88 satisfies the constraint. One draw in 8 is a
  // natural throw. A natural throw is 8 times as likely to satisfy the constraint as a draw.
  Tables tables;
  tables.world = "spelling";
  tables.log_natural_throw = 3 * std::log(0.5);
  tables.log_p = {-6.88, -6.88, -6.88};
  const json::Value said = json(tables);
  EXPECT_NEAR(said["log_p_satisfied"]["value"].get<double>(), -6.88, 1e-12);
  EXPECT_NEAR(said["log_p_throw"]["value"].get<double>(), -4.80, 1e-3);
  EXPECT_NE(said["natural_throw"], "");
}

TEST(ArchiveOdds, WhatNeverSatisfiedIsUnknown) {
  Tables tables;
  tables.log_p = {-4.8, -4.8, -k_infinity};
  json::Value said = json(tables);
  EXPECT_EQ(said["known"], false);
  EXPECT_EQ(said["log_p_satisfied"]["round"], 2);
  EXPECT_NEAR(said["log_p_satisfied"]["value"].get<double>(), -4.8, 1e-12);
  tables.log_p.assign(3, -k_infinity);
  said = json(tables);
  EXPECT_EQ(said["log_p_satisfied"]["ladders"], 0);
  EXPECT_EQ(said["to_know"]["rounds"], 4);
  EXPECT_EQ(said["to_know"]["at_least"], true);
}

/// Islands of chains. The first of every three islands has a larger estimate than the other two.
struct IslandTables {
  std::uint64_t chains = 4;
  std::uint64_t islands = 60;
  double log_p = -4.8;              ///< log p of the larger islands
  double log_low = std::log(0.25);  ///< log of the smaller islands' estimate relative to the larger
  std::vector<double> odds_from{};  ///< by chain; empty: no such table
  std::vector<double> odds_until{};  ///< by chain; empty: no such table
  std::string sampler{};
  std::string stop = "scans = 20\n";
  std::vector<double> values{};  ///< if not empty, all values of log P
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
  if (!tables.odds_until.empty())
    table("odds_until_island", {{"chain", tables.odds_until.size()}}, tables.odds_until);
  made.summary.world = "ball_2d";
  made.summary.request_text =
      "[sampler]\nmethod = \"sequential\"\n" + tables.sampler + "[stop]\n" + tables.stop;
  made.summary.chains = tables.chains;
  made.summary.scans = 20;
  return made;
}

json::Value json_of(const IslandTables& tables) {
  const Made made = islands_archive(tables);
  return as_json(odds_of(made.source, made.summary).value());
}

TEST(ArchiveOdds, IslandsOfAFixedNumberAllCount) {
  // Estimates of 1, 1/4 and 1/4 have mean 1/2 and relative variance 1/2 (times 240 / 239).
  const double log_p = -4.8 + std::log(0.5);
  const double error = std::sqrt(0.5 / 239);
  const json::Value said = json_of(IslandTables{});
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
}

TEST(ArchiveOdds, OfASizedRoundTheLastIslandsCount) {
  // Goal: islands before `odds_from` don't count, even if their estimates would dominate the sum.
  // Method: multiply the estimates of each chain's first 20 islands by e^9.
  IslandTables tables;
  for (std::uint64_t i = 0; i < tables.chains * tables.islands; ++i)
    tables.values.push_back((i % tables.islands < 20 ? 9 : 0) + (i % 3 == 0 ? -4.8 : -5.8));
  tables.odds_from.assign(4, 20);
  tables.stop = "scans = 20\nodds = 0.1\n";
  const json::Value said = json_of(tables);
  EXPECT_EQ(said["known"], true);
  EXPECT_EQ(said["odds_from_island"], 20);
  EXPECT_EQ(said["log_p_satisfied"]["islands"], 160);
  EXPECT_LT(said["log_p_satisfied"]["value"].get<double>(), -4.8);
}

TEST(ArchiveOdds, IslandsThatChoseTheirNumberAreUnknown) {
  // The advice never repeats an invalid `odds` of the request.
  for (const auto& [rule, advised] :
       {std::pair{"independent_solutions = 2\n", 0.1}, std::pair{"odds = 0.3\n", 0.3},
        std::pair{"odds = 7.0\n", 0.1}}) {
    IslandTables tables;
    tables.stop += rule;
    const json::Value said = json_of(tables);
    EXPECT_EQ(said["known"], false) << rule;
    EXPECT_EQ(said["to_know"]["odds"], advised) << rule;
  }
  Made made = islands_archive(IslandTables{});
  made.summary.request_text = "= no request";
  EXPECT_EQ(as_json(odds_of(made.source, made.summary).value())["known"], false);
}

TEST(ArchiveOdds, OneLargeIslandMakesThemUnknown) {
  // Earlier islands determined the round's size. One island's estimate is 0.4 of the sum of all
  // estimates. The advice is to use four times as many islands and half the error.
  IslandTables tables;
  tables.values.assign(240, -210);
  tables.values[100] = -210 + std::log(160);
  tables.odds_from.assign(4, 0);
  tables.stop = "scans = 20\nodds = 0.1\n";
  const json::Value said = json_of(tables);
  EXPECT_EQ(said["known"], false);
  EXPECT_NEAR(said["to_know"]["odds"].get<double>(), 0.049, 5e-4);
}

TEST(ArchiveOdds, WhatIsAdvisedSizesALongerRound) {
  // Goal: a request with the advised error gets more islands. Method: use 80 pilot islands and then
  // 160 islands. A third of the pilot islands have larger estimates. One of the later islands has a
  // huge estimate. The pilot islands predict an error of sqrt(0.5 * 80 / 79 / 160) = 0.0563. A
  // request for an error above the prediction gives the same number of islands. The advised error
  // must be below nine tenths of the prediction.
  IslandTables tables;
  for (std::uint64_t i = 0; i < tables.chains * tables.islands; ++i) {
    const bool is_large = i % tables.islands < 20 ? (i / 60 * 20 + i % 60) % 3 == 0 : i == 30;
    tables.values.push_back(is_large ? -4.8 : -4.8 + std::log(0.25));
  }
  tables.values[30] = 1;
  tables.odds_from.assign(4, 20);
  tables.stop = "scans = 20\nodds = 0.3\n";
  EXPECT_LT(json_of(tables)["to_know"]["odds"].get<double>(), 0.9 * 0.0564);
}

TEST(ArchiveOdds, WhatIsAdvisedCanBeAskedFor) {
  // Goal: the advised error is never NaN or below its minimum. Method: use two archives with a
  // heavy tail. The first islands of one archive are equal and predict an error of 0. The first
  // islands of the other archive have no solutions.
  IslandTables tables;
  tables.odds_from.assign(4, 20);
  tables.stop = "scans = 20\nodds = 0.3\n";
  tables.values.assign(240, -210);
  tables.values[100] = -200;
  EXPECT_EQ(json_of(tables)["to_know"]["odds"], request::k_odds_min);
  for (std::size_t i = 0; i < tables.values.size(); ++i)
    if (i % 60 < 20) tables.values[i] = -k_infinity;
  const auto advised = json_of(tables)["to_know"]["odds"].get<double>();
  EXPECT_GT(advised, request::k_odds_min);
  EXPECT_LT(advised, 0.3);
}

TEST(ArchiveOdds, OfARunForSolutionsTheFirstIslandsCount) {
  // Goal: in a run for solutions, only islands before `odds_until` determine the odds. Method: use
  // 60 islands per chain, and multiply the estimates of the last 30 by e^9.
  IslandTables tables;
  for (std::uint64_t i = 0; i < tables.chains * tables.islands; ++i)
    tables.values.push_back((i % tables.islands < 30 ? 0 : 9) + (i % 3 == 0 ? -4.8 : -5.8));
  tables.odds_until.assign(4, 30);
  tables.stop = "scans = 20\nindependent_solutions = 2\n";
  const json::Value said = json_of(tables);
  EXPECT_EQ(said["known"], true);
  EXPECT_EQ(said["odds_until_island"], 30);
  EXPECT_EQ(said["log_p_satisfied"]["islands"], 120);
  EXPECT_LT(said["log_p_satisfied"]["value"].get<double>(), -4.8);
  tables.odds_until.clear();
  EXPECT_EQ(json_of(tables)["known"], false);
}

TEST(ArchiveOdds, WhatElseHelpsIsAdvised) {
  // Goal: if islands have too few particles, the advice names the number of particles too. Method:
  // use islands of two particles each.
  IslandTables tables;
  tables.sampler = "tour_scans = 16\nparticles = 2\n";
  tables.stop = "independent_solutions = 2\n";
  const Made made = islands_archive(tables);
  const std::string besides =
      odds_of(made.source, made.summary).value().how_to_know.value().besides;
  EXPECT_THAT(besides, HasSubstr("particles"));
}

TEST(ArchiveOdds, IslandsKnowOddsThatNoDoubleHolds) {
  IslandTables tables;
  tables.log_p = -90 * std::log(10);
  tables.log_low = 0;
  EXPECT_NEAR(json_of(tables)["log10_throws"].get<double>(), 90, 1e-9);
  tables.log_p = -k_infinity;
  EXPECT_EQ(json_of(tables)["known"], false);
}

TEST(ArchiveOdds, IslandsThatCannotBeAreRefused) {
  // Goal: if a run can't have written an archive's tables, the archive is refused and causes no
  // crash. Method: write infinite or NaN estimates, an impossible number of the first counted
  // island, or a wrong number of chains. If no island counts, the archive is valid.
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
  IslandTables none;
  none.odds_from.assign(4, 60);
  EXPECT_EQ(json_of(none)["log_p_satisfied"]["islands"], 0);
}

TEST(ArchiveOdds, ARequestThatCannotBeReadIsNoMatter) {
  Tables tables;
  tables.round_trips = 0;
  Made made = archive_of(tables);
  made.summary.request_text = "= no request";
  const json::Value said = as_json(odds_of(made.source, made.summary).value());
  EXPECT_EQ(said["to_know"]["longer"], 40);
  EXPECT_EQ(said["to_know"]["at_least"], true);
}

}  // namespace
}  // namespace sleight::analysis
