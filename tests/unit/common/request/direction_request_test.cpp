// Goal: rules that involve several keys of a request are enforced. Method: read small requests of a
// toy world, and compare all their errors with the expected errors. More invalid requests are in
// tests/requests.
#include "common/request/direction_request.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/facts.h"
#include "tests/unit/common/request/toy_world.h"

namespace sleight::request::direction_request_test {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

DirectionRequest read(std::string_view text) {
  const std::array worlds{toy::binding()};
  auto request = read_request(text, "r.toml", worlds);
  if (!request) {
    for (const auto& d : request.error())
      ADD_FAILURE() << to_string(d);
    return {};
  }
  return std::move(request).value();
}

constexpr std::string_view k_least = "[world]\nname = 'toy'\n[stop]\nscans = 10\n";

constexpr std::string_view k_least_normalised = R"([world]
name = "toy"
height_m = 2.0
tilt_deg = 10.0
balls = 3
spinning = true
surface = "felt"

[constraint]
word = "HI"
lambda = 0.25

[sampler]
method = "parallel_tempering"
chains = 4
seed = 1
iterations_per_scan = 1
round_scans = 64
step = 0.1

[stop]
scans = 10

[output]
thin = 1
keep_max = 5000
keep_per_lineage = 3
min_distance = 0.5
prior_draws = 1000
)";

TEST(ReadRequest, SetsWhatIsGiven) {
  const DirectionRequest request = read(
      "[world]\nname='toy'\nballs=9\nspinning=false\nsurface='wood'\ntilt_deg=-90\n"
      "[constraint]\nword='OK'\n[sampler]\nmethod='metropolis_hastings'\nchains=65536\nseed="
      "9223372036854775807\nstep=0\n"
      "iterations_per_scan=7\nround_scans=8\n[stop]\nscans=1_000_000_000_000\nrounds=3\n"
      "independent_solutions=65536\n[output]\nthin=2\nkeep_max=0\nkeep_per_lineage=0\n"
      "min_distance=1\n");
  const auto& parameters = parameters_of<toy::Parameters>(request);
  EXPECT_EQ(parameters.balls, 9U);
  EXPECT_FALSE(parameters.spinning);
  EXPECT_EQ(parameters.surface, toy::Surface::wood);
  EXPECT_EQ(parameters.word, "OK");
  EXPECT_EQ(request.sampler,
            (SamplerParameters{Method::metropolis_hastings, 65536, {}, {}, k_seed_max, 7, 8}));
  EXPECT_EQ(request.stop, (StopRule{k_scans_max, 3, 65536}));
  EXPECT_EQ(request.output, (OutputParameters{2, 0, 0, 1.0}));
}

TEST(ReadRequest, NamesTheWorlds) {
  EXPECT_THAT(toy::errors_of("[world]\nname = 'toi'\nany = 1\n[constraint]\nthing = 2\n[sampler]\n"
                             "chains = 0\nx = 1\n[stop]\nscans = 1\nscan = 2"),
              ElementsAre(tests::LinesHaveFacts(
                              "r.toml:2:8: 'name' in [world]: |\"toy\"|\"toy_2\"|\"toi\"|\"toy\""),
                          tests::LinesHaveFacts("r.toml:7:10: 'chains' in [sampler]: |1|65536|0"),
                          tests::LinesHaveFacts("r.toml:11:1: |'scan' in [stop]|'scans'")));
}

TEST(ReadRequest, ChecksOfSeveralKeysAreAnchoredAtAKey) {
  EXPECT_THAT(toy::errors_of("[world]\nname = 'toy'\n[constraint]\n word = ''\n[stop]\nscans = 1"),
              ElementsAre("r.toml:4:2: 'word' in [constraint]: nothing to spell"));
}

TEST(ReadRequest, WithoutARuleItIsForFiveSolutions) {
  // Goal: if a request has no stop rule, it gets the default rule, five solutions. If a request has
  // a stop rule, it gets no other rule. Method: read three kinds of requests: without the section
  // [stop], with an empty section, and with one rule.
  for (const std::string stop : {"", "[stop]\n"}) {
    const DirectionRequest request = read("[world]\nname = 'toy'\n" + stop);
    EXPECT_EQ(request.stop, (StopRule{{}, {}, 5, {}}));
    EXPECT_THAT(normalised_text(request), HasSubstr("[stop]\nindependent_solutions = 5\n\n"));
    EXPECT_EQ(normalised_text(read(normalised_text(request))), normalised_text(request));
  }
  for (const std::string rule : {"scans = 1", "rounds = 1", "independent_solutions = 1"}) {
    const DirectionRequest request = read("[world]\nname = 'toy'\n[stop]\n" + rule);
    EXPECT_THAT(normalised_text(request), HasSubstr("[stop]\n" + rule + "\n\n"));
  }
}

TEST(ReadRequest, ASearchHasFewKeys) {
  // Goal: if a key doesn't apply to a search, it is refused, and a search's normalised text omits
  // it.
  const std::string least = "[world]\nname = 'staged'\n[sampler]\nmethod = 'search'\n";
  const std::array worlds{toy::binding(), toy::staged_binding()};
  const auto read_staged = [&](const std::string& text) {
    auto request = read_request(text, "r.toml", worlds);
    EXPECT_TRUE(request.ok()) << text;
    return std::move(request).value();
  };
  const auto staged_errors = [&](const std::string& text) {
    std::vector<std::string> lines;
    const auto request = read_request(text, "r.toml", worlds);
    for (const Diagnostic& error : request ? std::vector<Diagnostic>{} : request.error())
      lines.push_back(to_string(error));
    return lines;
  };
  const DirectionRequest request = read_staged(least + "seed = 3\n");
  EXPECT_EQ(request.sampler.chains, 0U);
  EXPECT_EQ(request.stop, (StopRule{{}, {}, {}, 5}));
  EXPECT_THAT(normalised_text(request),
              HasSubstr("[sampler]\nmethod = \"search\"\nseed = 3\n\n[stop]\nfound = 5\n\n"
                        "[output]\nkeep_max = 5000\n"));
  EXPECT_EQ(read_staged(normalised_text(request)), request);
  EXPECT_EQ(
      read_request(least + "seed = 3\n[stop]\nfound = 2\n", "r.toml", worlds, Asked{.number = 8})
          .value(),
      read_staged(least + "seed = 3\n[stop]\nfound = 8\n"));
  EXPECT_THAT(staged_errors(least + "chains = 2\nstep = 0.5\n"),
              ElementsAre(tests::HasFacts("'chains' in [sampler]: |relax_scans|does not use"),
                          tests::HasFacts("'step' in [sampler]: |relax_scans|does not use")));
  EXPECT_THAT(staged_errors(least + "[stop]\nscans = 7\n"),
              ElementsAre(HasSubstr("set 'found' instead")));
  EXPECT_THAT(staged_errors(least + "[output]\nmin_distance = 1\n"),
              ElementsAre(tests::HasFacts("'min_distance' in [output]: |method")));
  std::string other = least;
  other.replace(other.find("staged"), 6, "toy");
  EXPECT_THAT(staged_errors(other),
              ElementsAre(tests::HasFacts("'method' in [sampler]: |search|staged|toy")));
}

TEST(ReadRequest, OddsAreARuleOfIslands) {
  // Goal: the stop rule `odds` is accepted alone or together with certain rules, and reads back.
  // The rule requires the method "sequential" and a value in its range.
  const std::string islands = "[world]\nname = 'staged'\n[sampler]\nmethod = 'sequential'\n";
  const std::array worlds{toy::staged_binding()};
  const auto read_staged = [&](const std::string& text) {
    auto request = read_request(text, "r.toml", worlds);
    EXPECT_TRUE(request.ok()) << text;
    return std::move(request).value();
  };
  const auto staged_errors = [&](const std::string& text) {
    std::vector<std::string> lines;
    const auto request = read_request(text, "r.toml", worlds);
    for (const Diagnostic& error : request ? std::vector<Diagnostic>{} : request.error())
      lines.push_back(to_string(error));
    return lines;
  };
  const DirectionRequest alone = read_staged(islands + "[stop]\nodds = 0.1\n");
  EXPECT_EQ(alone.stop, (StopRule{{}, {}, {}, {}, 0.1}));
  EXPECT_THAT(normalised_text(alone), HasSubstr("[stop]\nodds = 0.1\n\n"));
  EXPECT_EQ(read_staged(normalised_text(alone)), alone);
  EXPECT_EQ(read_request(islands + "[stop]\nodds = 0.1\n", "r.toml", worlds, Asked{.number = 3})
                .value()
                .stop,
            (StopRule{{}, {}, 3, {}}));
  const DirectionRequest both =
      read_staged(islands + "[stop]\nfound = 2\nodds = 1\nscans = 100000\n");
  EXPECT_THAT(normalised_text(both),
              HasSubstr("[stop]\nscans = 100000\nodds = 1.0\nfound = 2\n\n"));
  for (const std::string bad : {"0", "0.0009", "1.1", "-0.1"}) {
    EXPECT_THAT(staged_errors(islands + "[stop]\nodds = " + bad + "\n"),
                ElementsAre(tests::HasFacts("'odds' in [stop]: |0.001|1")));
  }
  for (const std::string method :
       {"metropolis_hastings", "parallel_tempering", "simulated_tempering", "tempered_transitions",
        "annealed_importance"}) {
    EXPECT_THAT(
        staged_errors("[world]\nname = 'staged'\n[sampler]\nmethod = '" + method +
                      "'\n[stop]\nscans = 100000\nodds = 0.1\n"),
        ElementsAre(tests::LinesHaveFacts("r.toml:7:1: 'odds' in [stop]: |\"sequential\"")));
  }
  for (const std::string key : {"chains", "tour_scans", "burn_in_rounds", "round_scans"}) {
    EXPECT_THAT(staged_errors("[world]\nname = 'staged'\n[sampler]\nmethod = 'sequential'\n" + key +
                              " = 3\n[stop]\nodds = 0.1\n"),
                Contains(tests::HasFacts("'" + key + "' in [sampler]: |odds")));
  }
  for (const std::string rule : {"rounds", "independent_solutions"}) {
    EXPECT_THAT(staged_errors(islands + "[stop]\nodds = 0.1\n" + rule + " = 2\n"),
                ElementsAre(tests::HasFacts("'" + rule + "' in [stop]: |odds")));
  }
  EXPECT_THAT(staged_errors("[world]\nname = 'staged'\n[sampler]\nmethod = 'search'\n[stop]\n"
                            "odds = 0.1\n"),
              ElementsAre(HasSubstr("set 'found' instead")));
}

TEST(ReadRequest, ToursGoWithIslandsAndTheirOwnRules) {
  // Goal: the key `tour_scans` requires the method "sequential". If a key or a rule doesn't apply
  // to tours, it is refused.
  const std::array worlds{toy::staged_binding()};
  const auto staged_errors = [&](const std::string& method, const std::string& rest) {
    std::vector<std::string> lines;
    const auto request = read_request(
        "[world]\nname = 'staged'\n[sampler]\nmethod = '" + method + "'\ntour_scans = 8\n" + rest,
        "r.toml", worlds);
    for (const Diagnostic& error : request ? std::vector<Diagnostic>{} : request.error())
      lines.push_back(to_string(error));
    return lines;
  };
  EXPECT_THAT(staged_errors("sequential", "[stop]\nindependent_solutions = 3\n"), IsEmpty());
  EXPECT_THAT(staged_errors("sequential", "[stop]\nscans = 8\n"), IsEmpty());
  EXPECT_THAT(staged_errors("sequential", "[stop]\nscans = 7\n"),
              ElementsAre(tests::HasFacts("'scans' in [stop]: |more than|7")));
  EXPECT_THAT(staged_errors("sequential", "burn_in_rounds = 2\n[stop]\nscans = 50\n"),
              ElementsAre(tests::HasFacts("'burn_in_rounds' in [sampler]: |tour_scans")));
  EXPECT_THAT(staged_errors("sequential", "[stop]\nrounds = 2\n"),
              ElementsAre(tests::HasFacts("'rounds' in [stop]: |tour_scans")));
  EXPECT_THAT(staged_errors("parallel_tempering", "[stop]\nrounds = 2\n"),
              Contains(tests::HasFacts("'tour_scans' in [sampler]: |\"sequential\"")));
}

TEST(ReadRequest, FindsAskedForStayFinds) {
  // Goal: if a request has the rule `found`, the command line's number of solutions replaces the
  // number of finds. If the request also draws samples, the number also counts independent
  // solutions.
  const std::array worlds{toy::staged_binding()};
  const auto rules_of = [&](const std::string& text) {
    return read_request("[world]\nname = 'staged'\n" + text, "r.toml", worlds, Asked{.number = 4})
        .value()
        .stop;
  };
  EXPECT_EQ(rules_of("[stop]\nfound = 2\n"), (StopRule{{}, {}, {}, 4}));
  EXPECT_EQ(rules_of("[sampler]\nseed = 2\n[stop]\nfound = 2\n"), (StopRule{{}, {}, {}, 4}));
  EXPECT_EQ(rules_of("[stop]\nfound = 2\nscans = 9\n"), (StopRule{{}, {}, 4, 4}));
  EXPECT_EQ(rules_of("[sampler]\nchains = 2\n[stop]\nfound = 2\n"), (StopRule{{}, {}, 4, 4}));
}

TEST(ReadRequest, WithoutASamplerFindsAreRelaxed) {
  // Goal: if a world relaxes finds, a request without a sampler and a stop rule asks for five
  // takes. The section [stop] or the command line can set another number. Both can ask for finds or
  // draws instead of takes.
  const std::array worlds{toy::relaxing_binding()};
  const auto read_with = [&](const std::string& text, std::optional<Asked> asked) {
    auto request = read_request("[world]\nname = 'staged'\n" + text, "r.toml", worlds, asked);
    EXPECT_TRUE(request.ok()) << text;
    return std::move(request).value();
  };
  const DirectionRequest open = read_with("", {});
  const std::string text = normalised_text(open);
  EXPECT_THAT(text, HasSubstr("[sampler]\nmethod = \"search\"\nseed = 1\niterations_per_scan = 1\n"
                              "relax_scans = 3\nstep = 0.5\n\n[stop]\ntakes = 5\n\n"
                              "[output]\nkeep_max = 5000\nprior_draws = 100\n"));
  EXPECT_EQ(read_request(text, "c.toml", worlds).value(), open);
  EXPECT_EQ(parameters_of<toy::Parameters>(open).step, 0.5);
  EXPECT_EQ(read_with("", Asked{.number = 3}).stop.takes, 3U);
  EXPECT_EQ(read_with("[stop]\ntakes = 9\n", Asked{.number = 3}).stop.takes, 3U);
  const StopRule found{{}, {}, {}, 3};
  const StopRule in_proportion{{}, {}, 3, 3};
  EXPECT_EQ(read_with("", Asked{.answer = Answer::found, .number = 3}).stop, found);
  EXPECT_EQ(read_with("[stop]\nfound = 9\n", Asked{.number = 3}).stop, found);
  EXPECT_EQ(read_with("", Asked{.answer = Answer::in_proportion, .number = 3}).stop, in_proportion);
  EXPECT_EQ(read_with("[stop]\nindependent_solutions = 9\n", Asked{.number = 3}).stop,
            in_proportion);
  EXPECT_EQ(read_with("[stop]\nscans = 9\n", {}).stop.takes, std::nullopt);

  // The normalised request of an interrupted run states the number of takes so far. If there are no
  // takes yet, the request states the number of finds.
  EXPECT_THAT(normalised_text_of(open, {.found = 7, .relaxed = 2, .prior_draws = 40}),
              HasSubstr("relax_scans = 3\nstep = 0.5\n\n[stop]\ntakes = 2\n\n[output]\n"
                        "keep_max = 5000\nprior_draws = 40\n"));
  EXPECT_THAT(normalised_text_of(open, {.found = 7}),
              HasSubstr("[sampler]\nmethod = \"search\"\nseed = 1\n\n[stop]\nfound = 7\n"));

  const auto error_of = [&](const std::string& more) {
    const auto request = read_request("[world]\nname = 'staged'\n" + more, "r.toml", worlds);
    return request ? "" : to_string(request.error().front());
  };
  EXPECT_THAT(error_of("[stop]\ntakes = 5\nscans = 9\n"),
              tests::HasFacts("'takes' in [stop]: |\"search\"|relax_scans"));
  EXPECT_THAT(error_of("[sampler]\nrelax_scans = 2\n[stop]\nscans = 9\n"),
              tests::HasFacts("'relax_scans' in [sampler]: |\"search\""));
  EXPECT_THAT(error_of("[sampler]\nmethod = 'search'\nrelax_scans = 2\n[stop]\nfound = 9\n"),
              tests::HasFacts("'found' in [stop]: |relax_scans"));
}

TEST(NormalisedText, KeepsWhatIslandsEndARunBy) {
  // Goal: if a run with islands is interrupted, its request states the scans done, and keeps the
  // rules for solutions and odds. If the run has another method, its request states only the scans
  // done.
  const std::array worlds{toy::staged_binding()};
  const auto cut_of = [&](const std::string& method, const std::string& rules) {
    const auto request = read_request("[world]\nname = 'staged'\n[sampler]\nmethod = '" + method +
                                          "'\n[stop]\nscans = 5000\n" + rules,
                                      "r.toml", worlds);
    EXPECT_TRUE(request.ok());
    const std::string text =
        normalised_text_of(request.value(), {.scans = 777, .prior_draws = 1000});
    EXPECT_EQ(normalised_text(read_request(text, "c.toml", worlds).value()), text);
    return text;
  };
  const std::string solutions = "rounds = 6\nindependent_solutions = 2\n";
  EXPECT_THAT(cut_of("sequential", solutions + "found = 2\n"),
              HasSubstr("[stop]\nscans = 777\nindependent_solutions = 2\n\n"));
  EXPECT_THAT(cut_of("sequential", "odds = 0.1\n"),
              HasSubstr("[stop]\nscans = 777\nodds = 0.1\n\n"));
  EXPECT_THAT(cut_of("parallel_tempering", solutions), HasSubstr("[stop]\nscans = 777\n\n"));
}

TEST(ReadRequest, SolutionsAskedForReplaceTheRules) {
  const std::array worlds{toy::binding()};
  const std::string text = "[world]\nname='toy'\n[stop]\nscans = 7\nrounds = 2\n";
  const DirectionRequest request = read(text);
  const DirectionRequest other = read_request(text, "r.toml", worlds, Asked{.number = 9}).value();
  EXPECT_EQ(other.stop, (StopRule{{}, {}, 9, {}}));
  EXPECT_THAT(normalised_text(other), HasSubstr("[stop]\nindependent_solutions = 9\n\n"));
  EXPECT_EQ(identity_text(other), identity_text(request));
}

TEST(ReadRequest, PlainChainsGiveOneSolutionEach) {
  const std::string text =
      "[world]\nname = 'toy'\n[stop]\nindependent_solutions = 5\n[sampler]\n"
      "method = 'metropolis_hastings'\n";
  EXPECT_THAT(toy::errors_of(text + "chains = 5"), IsEmpty());
  EXPECT_THAT(toy::errors_of(text + "chains = 4"),
              ElementsAre(tests::HasFacts("4:1: 'independent_solutions' in [stop]: |4|chains|5")));
  EXPECT_THAT(toy::errors_of(text), ElementsAre(HasSubstr("set chains = 5 in [sampler]")));
}

TEST(ReadRequest, RoundsAreNoLongerThanAnyRun) {
  const std::string text = "[world]\nname = 'toy'\n[stop]\nrounds = 40\n[sampler]\nround_scans = ";
  EXPECT_THAT(toy::errors_of(text + "1"),
              ElementsAre(tests::HasFacts("4:1: 'rounds' in [stop]: |40 rounds|1000000000000")));
  EXPECT_THAT(toy::errors_of(text + "0"), ElementsAre(HasSubstr("6:15: 'round_scans'")));
  EXPECT_THAT(toy::errors_of("[world]\nname='toy'\n[stop]\nrounds = 33"), IsEmpty());
}

TEST(ReadRequest, ShowsAtMostSoManyErrors) {
  std::string text(k_least);
  for (int i = 0; i < 20000; ++i)
    text += fmt::format("k{} = 1\n", i);
  const auto errors = toy::errors_of(text);
  ASSERT_EQ(errors.size(), k_diagnostics_max + 1);
  EXPECT_THAT(errors.back(), HasSubstr("19800 more errors are not shown"));
}

TEST(NormalisedText, HasEveryKeyInAFixedOrder) {
  EXPECT_EQ(normalised_text(read(k_least)), k_least_normalised);
}

TEST(NormalisedText, DoesNotDependOnHowTheFileWroteIt) {
  EXPECT_EQ(
      normalised_text(read("# hi\nstop = { scans = 0xA }\n[sampler]\nseed = +1\n[world]\nballs "
                           "= 3\n'name' = \"\"\"toy\"\"\"\nheight_m = 2e0\n")),
      k_least_normalised);
}

TEST(NormalisedText, CanBeStoppedElsewhere) {
  const DirectionRequest request =
      read("[world]\nname='toy'\n[stop]\nrounds = 3\nindependent_solutions = 2\n");
  EXPECT_THAT(normalised_text(request),
              HasSubstr("[stop]\nrounds = 3\nindependent_solutions = 2\n\n"));
  std::string expected(k_least_normalised);
  expected.replace(expected.find("scans = 10"), 10, "scans = 77");
  EXPECT_EQ(normalised_text_of(request, {.scans = 77, .prior_draws = 1000}), expected);
  EXPECT_EQ(normalised_text(read(expected)), expected);
}

TEST(IdentityText, IsWhatTheChainsDependOn) {
  const auto identity = [](std::string_view more) {
    return identity_text(read("[world]\nname='toy'\n" + std::string(more)));
  };
  const std::string same = identity("[stop]\nscans=1");
  EXPECT_THAT(std::string(k_least_normalised), testing::StartsWith(same));
  EXPECT_EQ(identity("[stop]\nrounds=9\n[output]\nthin=3\nkeep_max=1"), same);
  EXPECT_NE(identity("balls=4\n[stop]\nscans=1"), same);
  EXPECT_NE(identity("[constraint]\nlambda=4\n[stop]\nscans=1"), same);
  EXPECT_NE(identity("[sampler]\nseed=4\n[stop]\nscans=1"), same);
  EXPECT_NE(identity("[sampler]\nstep=0.2\n[stop]\nscans=1"), same);
}

TEST(WithSeed, IsAsIfTheFileHadIt) {
  const DirectionRequest request = with_seed(read(k_least), k_seed_max);
  std::string text(k_least);  // not a sum of temporaries, which GCC 12 falsely warns about
  text += "[sampler]\nseed = 9223372036854775807";
  EXPECT_EQ(request, read(text));
}

TEST(ArraysOfTables, AreReadCheckedAndNormalised) {
  // Goal: tables in a section set values, and errors name the line of the table. The normalised
  // text and the identity contain the tables. Method: read a valid request. Read requests that have
  // one fault each.
  const std::array worlds{toy::binding()};
  const std::string pegs = "[[world.peg]]\ny_m = 2\n[[world.peg]]\nx_m = 3\n";
  const std::string text = "[world]\nname = 'toy'\n" + pegs + "[stop]\nscans = 1\n";
  const auto request = read_request(text, "r.toml", worlds);
  ASSERT_TRUE(request);
  EXPECT_EQ(parameters_of<toy::Parameters>(request.value()).pegs,
            (std::vector<toy::Peg>{{0.5, 2.0}, {3, {}}}));
  const std::string normal = normalised_text(request.value());
  EXPECT_THAT(normal, testing::HasSubstr("surface = \"felt\"\n\n[[world.peg]]\nx_m = 0.5\n"
                                         "y_m = 2.0\n\n[[world.peg]]\nx_m = 3.0\n\n[constraint]"));
  EXPECT_THAT(identity_text(request.value()), testing::HasSubstr("[[world.peg]]"));
  EXPECT_EQ(normalised_text(read_request(normal, "n.toml", worlds).value()), normal);
  const auto errors = [](const std::string& table) {
    return toy::errors_of("[world]\nname = 'toy'\n[stop]\nscans = 1\n" + table);
  };
  EXPECT_THAT(
      errors("[[world.peg]]\nx_n = 1\n"),
      testing::ElementsAre(tests::LinesHaveFacts("r.toml:6:1: |'x_n' in [[world.peg]]|'x_m'")));
  EXPECT_THAT(errors("[[world.peg]]\nthreads = 1\n"),
              testing::ElementsAre(testing::HasSubstr("command-line option")));
  EXPECT_THAT(errors("[[world.peg]]\n[[world.peg]]\ny_m = 0.5\n"),
              testing::ElementsAre("r.toml:7:1: 'y_m' in [[world.peg]]: is x_m"));
  EXPECT_THAT(errors("[[world.pig]]\nx_m = 1\n"),
              testing::ElementsAre(testing::HasSubstr("did you mean 'peg'")));
  EXPECT_THAT(errors("[[output.peg]]\nx_m = 1\n"),
              testing::ElementsAre(testing::HasSubstr("belongs in [world]")));
}

TEST(NestedTables, AreReadCheckedAndNormalised) {
  // Goal: tables and arrays in tables are read in any notation, and the normalised text has one. An
  // unknown key is found at any depth. Method: as above.
  const std::array worlds{toy::binding()};
  const std::string head = "[stop]\nscans = 1\n[world]\nname = 'toy'\n";
  const std::string wind = "scale = 2, from = 'NE', places = ['a', \"b\\\"\"]";
  const auto request = read_request(
      head + "wind = {" + wind + ", mps = [0, -0.0, -9], path = [[1, 2], [3, 4]], noise.sd = 2}\n" +
          "[[world.peg]]\n[[world.peg.ring]]\n[[world.peg.ring]]\nat_m = [1,\n 2]\n"
          "surface = 'wood'\n[[world.peg]]\ny_m = 1\n",
      "r.toml", worlds);
  ASSERT_TRUE(request) << to_string(request.error()[0]);
  const std::string normal = normalised_text(request.value());
  EXPECT_THAT(normal, testing::HasSubstr(
                          "surface = \"felt\"\n\n[[world.peg]]\nx_m = 0.5\n\n"
                          "[[world.peg.ring]]\nat_m = [0.5, -1.0]\nsurface = \"felt\"\n\n"
                          "[[world.peg.ring]]\nat_m = [1.0, 2.0]\nsurface = \"wood\"\n\n"
                          "[[world.peg]]\nx_m = 0.5\ny_m = 1.0\n\n"
                          "[world.wind]\nscale = 2.0\nfrom = \"NE\"\nmps = [0.0, 0.0, -9.0]\n"
                          "path = [[1.0, 2.0], [3.0, 4.0]]\nplaces = [\"a\", \"b\\\"\"]\n\n"
                          "[world.wind.noise]\nsd = 2.0\n\n[constraint]"));
  const auto again = read_request(normal, "n.toml", worlds);
  ASSERT_TRUE(again);
  EXPECT_EQ(again.value(), request.value());
  EXPECT_EQ(parameters_of<toy::Parameters>(again.value()),
            parameters_of<toy::Parameters>(request.value()));

  const auto errors = [&](const std::string& tables) { return toy::errors_of(head + tables); };
  EXPECT_THAT(errors("[[world.peg]]\n[[world.peg.ring]]\nat_n = 1\n"),
              testing::ElementsAre(
                  "r.toml:7:1: unknown key 'at_n' in [[world.peg.ring]]; did you mean 'at_m'?"));
  EXPECT_THAT(
      errors("wind = {" + wind + ", noise = {threads = 1}, nois = {}}\n"),
      testing::ElementsAre(
          testing::AllOf(testing::StartsWith("r.toml:5:"), testing::HasSubstr("command-line")),
          testing::HasSubstr("unknown key 'nois' in [world.wind]; did you mean 'noise'?")));
  EXPECT_THAT(errors("[[world.wind]]\n"),
              testing::ElementsAre(
                  tests::LinesHaveFacts("r.toml:5:1: 'wind' in [world]: |[world.wind]|array")));
  EXPECT_THAT(errors("[world.peg]\n"),
              testing::ElementsAre(tests::LinesHaveFacts("r.toml:5:1: |[[world.peg]]|a table")));
  EXPECT_THAT(errors("[world.wind]\nfrom = 'N'\n"),
              testing::ElementsAre(
                  tests::LinesHaveFacts("r.toml:5:8: 'scale' in [world.wind]: |missing"),
                  tests::LinesHaveFacts("r.toml:5:8: 'places' in [world.wind]: |2 strings")));
}

TEST(NestedTables, AreNoLongerThanTheLimit) {
  // Goal: if a request can be read, its normalised text can be read too. Method: short numbers with
  // long normalised text.
  struct Numbers {
    std::vector<double> all{};
  };
  const std::array worlds{bind_world<Numbers>("many", "", [](WorldSections& sections, Numbers& p) {
    sections.world.numbers("all", p.all, {.count_max = k_array_numbers_max}, {});
  })};
  const auto read = [&](std::string_view number) {
    std::string text = "[world]\nname = 'many'\nall = [";
    for (std::size_t i = 0; i < k_array_numbers_max; ++i)
      text += fmt::format("{}, ", number);
    return read_request(text + "]\n[stop]\nscans = 1", "r.toml", worlds);
  };
  const auto request = read("0.123456789");
  ASSERT_TRUE(request);
  EXPECT_TRUE(read_request(normalised_text(request.value()), "n.toml", worlds));
  const auto refused = read("1e15");
  ASSERT_FALSE(refused);
  EXPECT_THAT(to_string(refused.error()[0]), tests::HasFacts("r.toml:1:1: |1200257 bytes|1044480"));
}

TEST(RequestKeys, ListEveryKeyOnce) {
  std::string keys;
  for (const SectionKeys& section : request_keys(toy::binding())) {
    keys += section.name + ":";
    for (const KeySpec& spec : section.keys)
      keys += " " + spec.key;
    keys += "\n";
  }
  EXPECT_EQ(
      keys,
      "world: name height_m tilt_deg balls spinning surface peg wind\n"
      "[world.peg]: x_m y_m ring\n"
      "[world.peg.ring]: at_m surface\n"
      "world.wind: scale from name mps gusts path triangles places noise\n"
      "world.wind.noise: sd\n"
      "constraint: word lambda\n"
      "sampler: method start chains replicas ladder_power seed iterations_per_scan round_scans "
      "anneal_scans burn_in_rounds "
      "lanes steps_per_level particles tour_scans relax_scans step\n"
      "stop: scans rounds independent_solutions odds found takes\n"
      "output: thin keep_max keep_per_lineage min_distance prior_draws\n");
}

}  // namespace sleight::request::direction_request_test
