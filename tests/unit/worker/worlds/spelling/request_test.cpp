// The keys of a spelling request.
#include "worker/worlds/spelling/request.h"

#include <gtest/gtest.h>

#include <array>

namespace sleight::worlds::spelling {
namespace {

base::Result<request::DirectionRequest, std::vector<request::Diagnostic>> read(
    Parameters& parameters, const std::string& keys) {
  const std::array worlds{request_binding(parameters)};
  return request::read_request("[world]\nname = \"spelling\"\n" + keys + "\n[stop]\nscans = 1\n",
                               "r.toml", worlds);
}

/// The first diagnostic's text; empty if there is none.
std::string complaint(const std::string& keys) {
  Parameters parameters;
  const auto request = read(parameters, keys);
  return request.ok() ? "" : request.error().front().message;
}

TEST(SpellingRequest, DefaultsAreTheThesis) {
  // Goal: a request that gives no keys is the thesis's HI. Method: read one over other parameters.
  Parameters parameters;
  parameters.world.bin_m = 1;
  parameters.pattern = pattern_of_word("X", Font::rows_5).value();
  ASSERT_TRUE(read(parameters, "").ok());
  const Parameters defaults;
  EXPECT_EQ(parameters.pattern, hi());
  EXPECT_EQ(parameters.world.bin_m, 0.020);
  EXPECT_EQ(parameters.world.partition_m, 0.002);
  EXPECT_EQ(parameters.world.partition_height_m, 0.012);
  EXPECT_EQ(parameters.world.vertex_sd_m, defaults.world.vertex_sd_m);
  EXPECT_EQ(parameters.proposal.vertex_sd_m, defaults.proposal.vertex_sd_m);
  EXPECT_EQ(parameters.proposal.ball_sd_m, 0.020);
  EXPECT_EQ(parameters.constraint.log_lambda, 5);
}

TEST(SpellingRequest, PatternsComeFromWordsAndBitmaps) {
  // Goal: any word or bitmap, in a grid of its own or a given one. Method: each.
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

TEST(SpellingRequest, ErrorsSayWhatToDo) {
  // Goal: what can't be is refused, with the key. Method: one of each.
  EXPECT_NE(complaint("word = \"A\"\nbitmap = \"#.\"").find("not both"), std::string::npos);
  EXPECT_NE(complaint("word = \"A-B\"").find("no picture of '-'"), std::string::npos);
  EXPECT_NE(complaint("bitmap = \"#.\\n#\"").find("row 2 has 1 characters"), std::string::npos);
  EXPECT_NE(complaint("bitmap = \"..\"").find("designates no bin"), std::string::npos);
  EXPECT_NE(complaint("bitmap = \"#\"").find("2 bins"), std::string::npos);
  EXPECT_NE(complaint("columns = 6").find("the pattern needs 7"), std::string::npos);
  EXPECT_NE(complaint("word = \"ABCDEFGHIJKL\"").find("can be had"), std::string::npos);
  EXPECT_NE(complaint("ball_diameter_mm = 20").find("fit into a bin"), std::string::npos);
  EXPECT_NE(complaint("drop_height_mm = 12").find("above the partitions"), std::string::npos);
  EXPECT_NE(complaint("[sampler]\nchange_all = 0.5").find("add up to 1.46"), std::string::npos);
  EXPECT_NE(complaint("[sampler]\nenable_balls = 0.15\ndisable_balls = 0.17").find("way back"),
            std::string::npos);
}

}  // namespace
}  // namespace sleight::worlds::spelling
