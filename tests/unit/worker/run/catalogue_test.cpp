#include "worker/run/catalogue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/request/direction_request.h"
#include "worker/run/chain_worker.h"
#include "worker/run/search_start.h"
#include "worker/worlds/ball_2d/ball_2d.h"
#include "worker/worlds/spelling/pouring_stages.h"

namespace sleight::run {
namespace {

constexpr const char* k_request = R"(
  [world]
  name = "ball_2d"
  restitution = 0.5
  [sampler]
  method = "metropolis_hastings"
  chains = 3
  seed = 9
  iterations_per_scan = 2
  round_scans = 10
  [stop]
  rounds = 2
  [output]
  thin = 4
)";

request::DirectionRequest read(const Catalogue& catalogue, const std::string& text) {
  auto request = request::read_request(text, "r.toml", catalogue.bindings());
  EXPECT_TRUE(request.ok());
  return std::move(request).value();
}

TEST(Catalogue, ListsItsWorldsInOrder) {
  // Goal: the catalogue lists its worlds alphabetically. Each world has a summary and a reader that
  // reports the world's name.
  const Catalogue catalogue;
  const std::vector<request::WorldBinding> worlds = catalogue.bindings();
  ASSERT_FALSE(worlds.empty());
  EXPECT_TRUE(std::is_sorted(worlds.begin(), worlds.end(),
                             [](const auto& a, const auto& b) { return a.name < b.name; }));
  for (const request::WorldBinding& world : worlds) {
    EXPECT_FALSE(world.summary.empty());
    std::string text = "[world]\nname = \"" + world.name + "\"\n";
    if (world.name == "scene") text += "[[world.body]]\nname = \"a\"\nradius_mm = 5\n";
    const auto request = read(catalogue, text);
    EXPECT_EQ(catalogue.world_of(request).make_reader(request)->layout().world, world.name);
  }
}

TEST(SearchStart, RecordsItsNearestMiss) {
  // Goal: a search reads what start_record() writes about a start without a find.
  using World = worlds::spelling::StagedSpelling;
  const World world(worlds::spelling::Parameters{});
  const sampling::SearchEffort effort{.furthest = 1, .nearest = sampling::Miss{1, 31}};
  const std::vector<plan::ScanRecord> start{
      start_record<World>(world, std::nullopt, 0, effort, ScanCounts(0))};
  sampling::SearchLanes lanes(1, 1, {.stages = {"a", "b"}, .misses = {{"a", "mm"}, {"b", "ms"}}});
  while (const auto unit = lanes.next_unit(1))
    lanes.consume(unit->replica.chain, unit->first_scan, start);
  EXPECT_THAT(lanes.finds().gave_up_because,
              testing::HasSubstr("All got past a. The nearest missed b by 31 ms."));
}

TEST(Catalogue, WorkerFollowsTheRequest) {
  // Goal: if a request's key affects a unit's results, the key reaches the worker. Method: run a
  // unit by the catalogue's worker, and by workers that the test constructs itself. Only a worker
  // with the same three options gives the same results.
  const Catalogue catalogue;
  const request::DirectionRequest request = read(catalogue, k_request);
  read(catalogue, "[world]\nname = \"ball_2d\"\n");  // a later request must not affect the first
  const auto worker = catalogue.world_of(request).make_worker(request);
  worlds::ball_2d::Parameters parameters;
  parameters.world.restitution = 0.5;
  const ChainWorkerOptions options{.iterations_per_scan = 2, .thin = 4};
  const plan::Unit unit{.replica = {base::ChainId{1}, base::ReplicaId{0}},
                        .seed = 9,
                        .first_scan = {},
                        .scans = 50,
                        .starts = true};
  const auto run_with = [&](const worlds::ball_2d::Parameters& p, const ChainWorkerOptions& o) {
    return ChainWorker<worlds::ball_2d::Ball2d>(worlds::ball_2d::Ball2d(p), o).run(unit, {}).scans;
  };
  const auto scans = worker->run(unit, {}).scans;
  EXPECT_EQ(scans, run_with(parameters, options));
  EXPECT_NE(scans, run_with({}, options));
  EXPECT_NE(scans, run_with(parameters, {.iterations_per_scan = 1, .thin = 4}));
  EXPECT_NE(scans, run_with(parameters, {.iterations_per_scan = 2, .thin = 3}));
}

TEST(Catalogue, PlanFollowsTheRequest) {
  // Goal: the request's number of chains and its three stop rules reach the plan. Method: compare
  // the plan's total number of scans with the request. A plan that stops by solutions has no total,
  // and its first unit ends with the first round.
  const Catalogue catalogue;
  request::DirectionRequest request = read(catalogue, k_request);
  EXPECT_EQ(make_plan(request, catalogue.world_of(request))->scans_total(), 3U * 30U);
  request.stop.scans = 7;
  EXPECT_EQ(make_plan(request, catalogue.world_of(request))->scans_total(), 3U * 7U);
  request.stop = {};
  request.stop.independent_solutions = 2;
  const auto plan = make_plan(request, catalogue.world_of(request));
  EXPECT_EQ(plan->scans_total(), std::nullopt);
  EXPECT_EQ(plan->next_unit(1000)->scans, 10U);
}

TEST(Catalogue, UnitsHaveTheRequestsSeed) {
  // Goal: for each sampling method, with and without annealing, every unit contains the request's
  // seed.
  const Catalogue catalogue;
  request::DirectionRequest request = read(catalogue, k_request);
  const auto worker = catalogue.world_of(request).make_worker(request);
  request.sampler.burn_in_rounds = 1;
  for (const request::Method method :
       {request::Method::metropolis_hastings, request::Method::parallel_tempering,
        request::Method::simulated_tempering, request::Method::tempered_transitions,
        request::Method::annealed_importance}) {
    for (const std::uint64_t anneal_scans : {0U, 5U}) {
      request.sampler.method = method;
      request.sampler.anneal_scans = anneal_scans;
      const auto plan = make_plan(request, catalogue.world_of(request), request::Cut{.scans = 40});
      std::map<plan::ReplicaKey, base::Bytes> states;
      while (const auto unit = plan->next_unit(10)) {
        ASSERT_EQ(unit->seed, 9U);
        const plan::UnitResult result = worker->run(*unit, states[unit->replica]);
        states[unit->replica] = result.state_after;
        plan->consume(unit->replica, unit->first_scan, result.scans);
      }
      EXPECT_TRUE(plan->finished());
    }
  }
}

TEST(Catalogue, WhatItChoosesReadsBack) {
  // Goal: if a request has no sampler, it may combine stop rules in every way that its world
  // allows. Reading the normalised request again gives the same request. Method: try every
  // combination of the rules for a short word, a long word and the other worlds. A request is
  // invalid only in three cases: it has `found`, and the world has no search; it has `odds`, and
  // the world has no islands; `odds` is combined with `rounds` or `independent_solutions`.
  const Catalogue catalogue;
  struct World {
    std::string keys;
    bool has_search = true;
    bool has_islands = true;
  };
  const std::vector<World> worlds{
      {"name = \"spelling\"\nword = \"HI\""},
      {"name = \"spelling\"\nword = \"ACM\""},
      {"name = \"ball_2d\"", false, false},
      {"name = \"dice\"\n[[world.die]]"},
      {"name = \"scene\"\n[[world.body]]\nname = \"a\"\nradius_mm = 5"}};
  const std::vector<std::string> rules{"scans = 1000", "rounds = 3", "independent_solutions = 4",
                                       "found = 2", "odds = 0.5"};
  for (const auto& [world, has_search, has_islands] : worlds) {
    for (unsigned subset = 0; subset < 1U << rules.size(); ++subset) {
      std::string text = "[world]\n" + world + "\n[stop]\n";
      for (unsigned rule = 0; rule < rules.size(); ++rule) {
        if ((subset >> rule) % 2 == 1) text += rules[rule] + "\n";
      }
      const auto request = request::read_request(text, "r.toml", catalogue.bindings());
      const bool has_found = (subset >> 3U) % 2 == 1;
      const bool has_odds = (subset >> 4U) != 0;
      const bool goes_with_odds = (subset & 0b110U) == 0;
      ASSERT_EQ(request.ok(),
                (has_search || !has_found) && (!has_odds || (has_islands && goes_with_odds)))
          << text;
      if (!request.ok()) continue;
      const std::string normal = request::normalised_text(request.value());
      const auto again = request::read_request(normal, "normal.toml", catalogue.bindings());
      ASSERT_TRUE(again.ok()) << normal;
      EXPECT_EQ(again.value(), request.value()) << normal;
      EXPECT_EQ(request::normalised_text(again.value()), normal);
    }
  }
}

}  // namespace
}  // namespace sleight::run
