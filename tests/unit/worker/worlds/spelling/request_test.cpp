#include "worker/worlds/spelling/request.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "worker/worlds/spelling/spelling.h"

namespace sleight::worlds::spelling {
namespace {

/// The only method that is valid with the thesis's kernel.
const std::string k_plain_chains = "method = \"metropolis_hastings\"\n";

base::Result<request::DirectionRequest, std::vector<request::Diagnostic>> read(
    Parameters& parameters, const std::string& keys) {
  const std::array worlds{request_binding()};
  // Without a method, the world would choose the sampler.
  const std::string open = keys.find("[sampler]") == std::string::npos
                               ? "\n[sampler]\nmethod = \"parallel_tempering\""
                               : "";
  auto request = request::read_request(
      "[world]\nname = \"spelling\"\n" + keys + open + "\n[stop]\nscans = 1\n", "r.toml", worlds);
  if (request.ok()) parameters = request::parameters_of<Parameters>(request.value());
  return request;
}

/// Text of the first diagnostic. Empty if none.
std::string complaint(const std::string& keys) {
  Parameters parameters;
  const auto request = read(parameters, keys);
  return request.ok() ? "" : request.error().front().message;
}

TEST(SpellingRequest, DefaultsAreTheThesis) {
  // Goal: a request without keys describes the thesis's example HI.
  Parameters parameters;
  ASSERT_TRUE(read(parameters, "").ok());
  const Parameters defaults;
  EXPECT_EQ(parameters.pattern, hi());
  const auto bits = [](const Parameters& p) {
    const WorldParameters& w = p.world;
    const ProposalParameters& q = p.proposal;
    return std::vector<double>{w.bin_m,           w.partition_m,     w.partition_height_m,
                               w.box_height_m,    w.drop_height_m,   w.vertex_sd_m,
                               w.dome_m,          w.ball_diameter_m, w.density_kgpm3,
                               w.drop_interval_s, w.restitution,     w.friction,
                               w.gravity_mps2,    w.bounce_end,      w.rest_speed,
                               w.rest_time,       w.time_limit_s,    p.constraint.log_lambda,
                               q.change_all,      q.change_vertices, q.change_ball,
                               q.disable_balls,   q.enable_balls,    q.vertex_probability,
                               q.vertex_sd_m,     q.ball_sd_m,       q.flip_probability};
  };
  EXPECT_EQ(bits(parameters), bits(defaults));
  EXPECT_EQ(parameters.world.bin_m, 0.020);
  EXPECT_EQ(parameters.world.partition_height_m, 0.012);
  EXPECT_EQ(parameters.world.drop_height_m, 0.072);
}

TEST(SpellingRequest, WithoutASamplerTheWorldChooses) {
  // Goal: if a request has no sampler, the world chooses a sampler, and the normalised text
  // contains all choices. The choices depend on the word and on the kinds of stop rules, but not on
  // the rules' numbers. If a request gives a value, the world keeps it.
  Parameters parameters;
  const std::array worlds{request_binding()};
  const auto chosen = [&](const std::string& text) {
    auto request = request::read_request("[world]\nname = \"spelling\"\n" + text, "r.toml", worlds);
    EXPECT_TRUE(request.ok()) << text;
    parameters = request::parameters_of<Parameters>(request.value());
    return std::move(request).value();
  };
  const auto islands = chosen("word = \"HI\"\n[stop]\nindependent_solutions = 7\n");
  EXPECT_EQ(islands.sampler.method, request::Method::sequential);
  EXPECT_EQ(islands.stop.found, 7U);
  EXPECT_EQ(islands.sampler.tour_scans, 16U);
  EXPECT_EQ(parameters.proposal.vertex_redraw, 1);
  EXPECT_EQ(parameters.constraint.log_lambda, 9);
  const std::string text = normalised_text(islands);
  EXPECT_NE(text.find("method = \"sequential\""), std::string::npos);
  EXPECT_NE(text.find("[stop]\nindependent_solutions = 7\nfound = 7\n"), std::string::npos);
  const auto again = request::read_request(text, "r.toml", worlds);
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(again.value(), islands);
  EXPECT_EQ(parameters.proposal.ball_sd_m, 0.002);
  EXPECT_EQ(parameters.constraint.log_lambda, 9);

  const auto takes = chosen("word = \"HI\"\n");
  EXPECT_EQ(takes.sampler.method, request::Method::search);
  EXPECT_EQ(takes.stop.takes, 5U);
  EXPECT_GT(takes.sampler.relax_scans.value(), 0U);
  EXPECT_EQ(takes.sampler.iterations_per_scan, 16U);
  EXPECT_EQ(parameters.constraint.log_lambda, 8);
  const auto chains = chosen(
      "word = \"SLEIGHT\"\n[constraint]\nlog_lambda = 5\n[stop]\nindependent_solutions = 5\n");
  EXPECT_EQ(chains.sampler.method, request::Method::metropolis_hastings);
  EXPECT_EQ(chains.sampler.start, request::Start::search);
  EXPECT_EQ(parameters.constraint.log_lambda, 5);
  EXPECT_EQ(chains.stop.independent_solutions, 5U);
  EXPECT_EQ(identity_text(chosen("word = \"HI\"\n[stop]\nindependent_solutions = 70\n")),
            identity_text(islands));
  const auto seeded = chosen("word = \"HI\"\n[sampler]\nseed = 8\n[stop]\nscans = 30\n");
  EXPECT_EQ(seeded.sampler.method, request::Method::sequential);
  EXPECT_EQ(seeded.sampler.seed, 8U);
  EXPECT_EQ(seeded.stop.found, std::nullopt);
  EXPECT_EQ(seeded.sampler.tour_scans, std::nullopt);  // a chain that continues has more draws
  const auto rounds = chosen("word = \"SLEIGHT\"\n[stop]\nrounds = 3\n");
  EXPECT_EQ(rounds.sampler.method, request::Method::parallel_tempering);
  EXPECT_EQ(rounds.sampler.start, request::Start::search);
  const auto odds = chosen("word = \"HI\"\n[stop]\nodds = 0.3\n");
  EXPECT_EQ(odds.sampler.method, request::Method::sequential);
  EXPECT_EQ(odds.sampler.particles, 48U);
  EXPECT_EQ(odds.output.prior_draws, 100U);
  EXPECT_EQ(odds.output.keep_max, 20U);
  // Naming the only method that gives odds changes nothing.
  const std::string named = "[sampler]\nmethod = \"sequential\"\n[stop]\nodds = 0.3\n";
  EXPECT_EQ(chosen("word = \"HI\"\n" + named), odds);
  EXPECT_EQ(chosen("word = \"SLEIGHT\"\n[stop]\nodds = 0.3\n").sampler.particles, 96U);
  const auto finds = chosen("word = \"HI\"\n[stop]\nfound = 3\n");
  EXPECT_EQ(finds.sampler.method, request::Method::search);
  EXPECT_EQ(finds.stop.independent_solutions, std::nullopt);
  const auto given = chosen("word = \"HI\"\n[sampler]\nchains = 2\n");
  EXPECT_EQ(given.sampler.method, request::Method::parallel_tempering);
  EXPECT_EQ(parameters.proposal.vertex_redraw, 0);
}

TEST(SpellingRequest, IslandsHaveAStatedMemory) {
  // Goal: a request is refused if its particles would exceed the documented memory. Method: use
  // boxes in which every bin is to be filled.
  const std::array worlds{request_binding()};
  const auto complaint_of = [&](std::uint32_t columns, std::uint32_t particles) {
    std::string bitmap;
    for (std::uint32_t row = 0; row < 12; ++row)
      bitmap += std::string(columns, '#') + "\\n";
    const auto request = request::read_request(
        "[world]\nname = \"spelling\"\nbitmap = \"" + bitmap +
            "\"\n[sampler]\nmethod = \"sequential\"\nparticles = " + std::to_string(particles) +
            "\n[stop]\nscans = 50000\n",
        "r.toml", worlds);
    return request.ok() ? "" : request.error().front().message;
  };
  EXPECT_EQ(complaint_of(10, 256), "");
  EXPECT_EQ(complaint_of(64, 64), "");
  EXPECT_NE(complaint_of(64, 4096).find("4096 particles of 768 balls"), std::string::npos)
      << complaint_of(64, 4096);
}

TEST(SpellingRequest, PatternsComeFromWordsAndBitmaps) {
  // Goal: a request accepts any word or bitmap. If no grid is given, the pattern's own grid is
  // used.
  Parameters parameters;
  ASSERT_TRUE(read(parameters, "word = \"ACM\"\n[constraint]\nlog_lambda = 7.25").ok());
  EXPECT_EQ(parameters.pattern.columns, 15U);
  EXPECT_EQ(parameters.pattern.count(), 30U);
  EXPECT_EQ(parameters.constraint.log_lambda, 7.25);
  ASSERT_TRUE(read(parameters, "word = \"a\"\nfont = \"7 rows\"\ncolumns = 20\nrows = 12").ok());
  EXPECT_EQ(parameters.pattern.columns, 20U);
  EXPECT_EQ(parameters.pattern.rows, 12U);
  ASSERT_TRUE(read(parameters, "bitmap = \"\"\"\n..#\n.#.\n\"\"\"").ok());
  EXPECT_EQ(parameters.pattern.columns, 3U);
  EXPECT_TRUE(parameters.pattern.at(2, 0));
  EXPECT_TRUE(parameters.pattern.at(1, 1));
  EXPECT_EQ(parameters.pattern.count(), 2U);
}

TEST(SpellingRequest, WhatIsAcceptedCanBeMade) {
  // Goal: no valid request stops the program. Method: simulate boxes that are one bin wide. The
  // balls have the largest valid size.
  for (const char* keys : {"bitmap = \"#\\n#\"\nball_diameter_mm = 19.99\nbox_height_mm = 60",
                           "bitmap = \"#.\"\nball_diameter_mm = 19.99"}) {
    Parameters parameters;
    ASSERT_EQ(complaint(keys), "") << keys;
    ASSERT_TRUE(read(parameters, keys).ok());
    const Spelling world(parameters);
    random::Stream stream({.seed = 1, .purpose = random::Purpose::prior}, 0);
    const State state = world.draw_prior(stream);
    const Outcome outcome = world.simulate(state);
    EXPECT_EQ(outcome.filled + outcome.elsewhere, state.active_count());
  }
}

TEST(SpellingRequest, ErrorsSayWhatToDo) {
  // Goal: an error about a request says what is wrong and which values are valid.
  EXPECT_NE(complaint("word = \"A\"\nbitmap = \"#.\"").find("not both"), std::string::npos);
  EXPECT_NE(complaint("word = \"A-B\"").find("no '-'"), std::string::npos);
  EXPECT_NE(complaint("bitmap = \"#.\\n#\"").find("row 2 has 1 characters"), std::string::npos);
  EXPECT_NE(complaint("bitmap = \"..\"").find("no designated bins"), std::string::npos);
  EXPECT_NE(complaint("bitmap = \"#\"").find("2 bins"), std::string::npos);
  EXPECT_NE(complaint("word = \"\u00c9\"").find("no '\u00c9'"), std::string::npos);
  EXPECT_NE(complaint("bitmap = \"#\\t\"").find("\\u{9}"), std::string::npos);
  EXPECT_NE(complaint("columns = 6").find("at least 7"), std::string::npos);
  EXPECT_NE(
      complaint("word = \"ABCDEFGHIJKLMNOPQ\"").find("72 x 7 bins, but the maximum is 64 x 12"),
      std::string::npos);
  EXPECT_NE(complaint("ball_diameter_mm = 20").find("at most 19.99"), std::string::npos);
  EXPECT_NE(complaint("drop_height_mm = 12").find("at least 13"), std::string::npos);
  EXPECT_NE(complaint("partition_height_mm = 8").find("must be above 8."), std::string::npos);
  EXPECT_NE(complaint("bin_mm = 1000\npartition_mm = 0.5\nvertex_sd_mm = 0.01")
                .find("must be at least 1 (a thousandth"),
            std::string::npos);
  EXPECT_NE(complaint("dome_mm = 12.5").find("must be at most 12 (partition_height_mm)"),
            std::string::npos);
  EXPECT_NE(complaint("vertex_sd_mm = 0.5").find("at most 0.2"), std::string::npos);
  EXPECT_NE(complaint("bounce_end = 0.1").find("at least 0.2 (2 times bounce_end), found 0.1"),
            std::string::npos);
  EXPECT_NE(complaint("rest_time = 0.09").find("at least 0.1 (2 times bounce_end"),
            std::string::npos);
  EXPECT_EQ(complaint("bounce_end = 0.045"), "");
  EXPECT_EQ(complaint("partition_mm = 0.3\nvertex_sd_mm = 0.03"), "");
  EXPECT_NE(complaint("[sampler]\nchange_all = 0.5").find("add up to 1, found 1.46"),
            std::string::npos);
  EXPECT_NE(complaint("[sampler]\nenable_balls = 0.15\ndisable_balls = 0.17")
                .find("must equal disable_balls"),
            std::string::npos);
}

TEST(SpellingRequest, TheThesisKernelIsAskedForByName) {
  // Goal: only the key `kernel` selects the biased kernel, and archives store that key. Method:
  // read requests that have the key, lack the key, or give the key an unknown value.
  Parameters parameters;
  const auto plain = read(parameters, "");
  ASSERT_TRUE(plain.ok());
  EXPECT_EQ(parameters.proposal.kernel, Kernel::correct);
  EXPECT_NE(normalised_text(plain.value()).find("kernel = \"correct\""), std::string::npos);
  const auto biased = read(parameters, "[sampler]\n" + k_plain_chains + "kernel = \"thesis\"");
  ASSERT_TRUE(biased.ok());
  EXPECT_EQ(parameters.proposal.kernel, Kernel::thesis);
  EXPECT_NE(normalised_text(biased.value()).find("kernel = \"thesis\""), std::string::npos);
  EXPECT_NE(identity_text(biased.value()), identity_text(plain.value()));
  EXPECT_NE(complaint("[sampler]\nkernel = \"printed\"").find("\"correct\""), std::string::npos);
  EXPECT_NE(complaint("[sampler]\nkernel = \"thesis\"").find("(the default); set method"),
            std::string::npos);
}

TEST(SpellingRequest, KindsThatAreNotOfTheThesisAreAskedForByName) {
  // Goal: aimed drops and solo steps are off by default and are refused with the thesis's kernel.
  // Aiming requires scattering.
  Parameters parameters;
  ASSERT_TRUE(read(parameters, "").ok());
  EXPECT_EQ(parameters.proposal.aim_ball, 0);
  EXPECT_EQ(parameters.proposal.solo_steps, 0U);
  const std::string aims = "change_all = 0\naim_ball = 0.03\nscatter_ball = 0.01\n";
  ASSERT_TRUE(read(parameters, "[sampler]\nsolo_steps = 12\n" + aims).ok());
  EXPECT_EQ(parameters.proposal.aim_ball, 0.03);
  EXPECT_EQ(parameters.proposal.solo_steps, 12U);
  EXPECT_NE(complaint("[sampler]\n" + k_plain_chains + "kernel = \"thesis\"\nsolo_steps = 3")
                .find("A.2.2"),
            std::string::npos);
  EXPECT_NE(
      complaint("[sampler]\n" + k_plain_chains + "kernel = \"thesis\"\n" + aims).find("A.2.2"),
      std::string::npos);
  EXPECT_NE(complaint("[sampler]\nchange_all = 0\naim_ball = 0.04").find("together with aim_ball"),
            std::string::npos);
  EXPECT_NE(complaint("[sampler]\nsolo_steps = 1001").find("1000"), std::string::npos);
}

}  // namespace
}  // namespace sleight::worlds::spelling
