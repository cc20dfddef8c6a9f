// Goal: if a key is set with `--set`, it works like a key in the file, and its errors name the
// option. Ranges expand to all combinations, in order. Method: read each request twice, once with
// `--set` and once with the same keys in the file. Compare both.
#include "common/request/sets.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/facts.h"
#include "tests/unit/common/request/toy_world.h"

namespace sleight::request {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using Texts = std::vector<std::string>;

constexpr std::string_view k_file =
    "[world]\nname = \"toy\"\nballs = 2\n\n[sampler]\nseed = 5\n\n[stop]\nscans = 10\n";

std::vector<std::string> lines_of(const std::vector<Diagnostic>& errors) {
  std::vector<std::string> lines;
  for (const Diagnostic& error : errors)
    lines.push_back(to_string(error));
  return lines;
}

std::string read(const Texts& texts, std::string_view file = k_file) {
  const auto sets = plain_sets(texts);
  std::string told;
  if (!sets) {
    for (const std::string& line : lines_of(sets.error()))
      told += line + '\n';
    return told;
  }
  const std::array worlds{toy::binding()};
  const auto request = read_request_with(file, "r.toml", worlds, sets.value());
  if (request) return normalised_text(request.value());
  for (const std::string& line : lines_of(request.error()))
    told += line + '\n';
  return told;
}

std::string read_file(const std::string& file) {
  return read({}, file);
}

TEST(Sets, AreReadAsIfTheFileHadThem) {
  const std::string seven =
      "[world]\nname = \"toy\"\nballs = 2\n[sampler]\nseed = 7\n[stop]\nscans = 10\n";
  EXPECT_EQ(read({"sampler.seed=7"}), read_file(seven));
  EXPECT_EQ(read({"sampler.seed=7", "world.surface=wood", "output.thin=3",
                  "constraint.word=\"A B\"", "constraint.lambda=2", "world.spinning=false"}),
            read_file("[world]\nname = \"toy\"\nballs = 2\nsurface = \"wood\"\nspinning = false\n"
                      "[sampler]\nseed = 7\n[constraint]\nword = \"A B\"\nlambda = 2\n"
                      "[stop]\nscans = 10\n[output]\nthin = 3\n"));
  // The order of the `--set` options doesn't matter, nor does a key's value in the file.
  EXPECT_EQ(read({"stop.scans=20", "world.balls=4"}), read({"world.balls=4", "stop.scans=20"}));
  EXPECT_EQ(read({"world.balls=4"}, "[world]\nname = \"toy\"\nballs = \"x\"\n[stop]\nscans = 10\n"),
            read_file("[world]\nname = \"toy\"\nballs = 4\n[stop]\nscans = 10\n"));
  EXPECT_NE(read({"sampler.seed=7"}), read({"sampler.seed=8"}));
}

TEST(Sets, BareWordsAreStrings) {
  EXPECT_EQ(read({"constraint.word=HI"}), read({"constraint.word=\"HI\""}));
  EXPECT_EQ(read({"constraint.word='HI'"}), read({"constraint.word=\"HI\""}));
  EXPECT_EQ(read({"constraint.word=A=B"}), read({"constraint.word=\"A=B\""}));
  EXPECT_EQ(read({"constraint.word=#1"}), read({"constraint.word=\"#1\""}));
  EXPECT_THAT(read({"sampler.seed=07"}),
              tests::LinesHaveFacts(
                  "--set sampler.seed=07: 'seed' in [sampler]: |0|9223372036854775807|\"07\""));
  EXPECT_THAT(read({"sampler.seed=1\n[world]"}), HasSubstr("found the string \"1\\u{a}[world]\""));
}

TEST(Sets, ReplaceTablesOfAnArray) {
  EXPECT_THAT(read({"world.peg=3"},
                   "[world]\nname = \"toy\"\n[[world.peg]]\nx_m = 1\n[stop]\nscans = 10\n"),
              tests::HasFacts("--set world.peg=3: 'peg' in [world]: |tables"));
}

TEST(Sets, ReachNoTables) {
  const std::string refused = "|SECTION.KEY=VALUE|keys of a table";
  for (const char* set : {"world.wind.scale=1", "world.peg.x_m=1", "world.peg.ring.at_m=[1,2]"})
    EXPECT_THAT(read({set}), tests::LinesHaveFacts(std::string("--set ") + set + ": " + refused));
  const std::string head = "[world]\nname = \"toy\"\n";
  for (const char* pegs : {"", "[[world.peg]]\n"})
    EXPECT_THAT(
        read({"world.peg=[{x_m=1}]"}, head + pegs + "[stop]\nscans = 10\n"),
        tests::LinesHaveFacts("--set world.peg=[{x_m=1}]: 'peg' in [world]: |tables|array"));
}

TEST(Sets, HaveTheErrorsOfAFile) {
  EXPECT_THAT(read({"sampler.sed=1"}),
              tests::LinesHaveFacts("--set sampler.sed=1: |'sed' in [sampler]|'seed'"));
  EXPECT_THAT(read({"samplr.seed=1"}),
              tests::LinesHaveFacts("--set samplr.seed=1: |[samplr]|[sampler]"));
  EXPECT_THAT(read({"seed=1"}), tests::LinesHaveFacts("--set seed=1: |'seed'|[sampler]"));
  EXPECT_THAT(
      read({"world.surface=wod"}),
      tests::LinesHaveFacts(
          "--set world.surface=wod: 'surface' in [world]: |\"felt\"|\"wood\"|\"wod\"|\"wood\""));
  EXPECT_THAT(
      read({"world.name=tou"}),
      tests::LinesHaveFacts("--set world.name=tou: 'name' in [world]: |\"toy\"|\"tou\"|\"toy\""));
  EXPECT_THAT(read({"world.threads=4"}),
              tests::LinesHaveFacts("--set world.threads=4: |'threads'|command-line option"));
  // Each error names the `--set` option that caused it. Errors of the file keep their places.
  EXPECT_THAT(read({"world.balls=4", "world.balls_=4", "sampler.step=1.5"},
                   "[world]\nname = \"toy\"\nbals = 1\n[stop]\nscans = 10\n"),
              tests::LinesHaveFacts("--set world.balls_=4: |'balls_' in [world]|'balls'\n"
                                    "--set sampler.step=1.5: 'step' in [sampler]: |0|1|1.5\n"
                                    "r.toml:3:1: |'bals' in [world]|'balls'"));
}

TEST(Sets, ThatCannotBeReadSayWhy) {
  const std::string form = "|SECTION.KEY=VALUE";
  EXPECT_THAT(read({"sampler.seed"}), tests::LinesHaveFacts("--set sampler.seed: " + form));
  EXPECT_THAT(read({"=1"}), tests::LinesHaveFacts("--set =1: " + form));
  EXPECT_THAT(read({".seed=1"}), tests::LinesHaveFacts("--set .seed=1: " + form));
  EXPECT_THAT(read({"sampler.=1"}), tests::LinesHaveFacts("--set sampler.=1: " + form));
  EXPECT_THAT(read({""}), tests::LinesHaveFacts("--set : " + form));
  EXPECT_THAT(read({"world.peg.x_m=1"}),
              tests::LinesHaveFacts("--set world.peg.x_m=1: " + form + "|table"));
  EXPECT_THAT(read({"sampler.seed="}), tests::LinesHaveFacts("--set sampler.seed=: |'='|'\"\"'"));
  EXPECT_THAT(read({"constraint.word=\"HI"}), HasSubstr("=\"HI: not valid TOML: "));
  EXPECT_THAT(read({"world.balls=[1, 2"}), HasSubstr("not valid TOML: "));
  EXPECT_EQ(read({std::string("constraint.word=\xff")}),
            "--set constraint.word=\\xff: expected UTF-8 text\n");
  EXPECT_THAT(read({"sampler.seed=1", "sampler.seed=2"}),
              tests::LinesHaveFacts("--set sampler.seed=2: |twice"));
  EXPECT_THAT(read(Texts(k_sets_max + 1, "a.b=1")), HasSubstr("at most 100 --set options"));
  EXPECT_THAT(read({"sampler.seed=1..3", "world.balls=2"}),
              tests::LinesHaveFacts("--set sampler.seed=1..3: |range|`sleight submit`"));
  EXPECT_THAT(read({"sampler.seed={1}"}), HasSubstr("found a range"));
}

std::vector<std::string> expanded(const Texts& texts) {
  const auto combinations = expand_sets(texts);
  if (!combinations) return lines_of(combinations.error());
  std::vector<std::string> told;
  for (const std::vector<KeySet>& sets : combinations.value()) {
    std::string line;
    for (const KeySet& set : sets)
      line += (line.empty() ? "" : " ") + set.text;
    told.push_back(line);
  }
  return told;
}

TEST(Ranges, MakeAllCombinations) {
  EXPECT_THAT(expanded({}), ElementsAre(""));
  EXPECT_THAT(expanded({"a.b=1"}), ElementsAre("a.b=1"));
  EXPECT_THAT(expanded({"a.b=-1..1"}), ElementsAre("a.b=-1", "a.b=0", "a.b=1"));
  EXPECT_THAT(expanded({"a.b=4..4"}), ElementsAre("a.b=4"));
  EXPECT_THAT(expanded({"a.b={HI,\"A,B\",3..4}"}),
              ElementsAre("a.b=HI", "a.b=\"A,B\"", "a.b=3", "a.b=4"));
  EXPECT_THAT(expanded({"a.b=1..2", "c.d=x", "e.f={7,9}"}),
              ElementsAre("a.b=1 c.d=x e.f=7", "a.b=1 c.d=x e.f=9", "a.b=2 c.d=x e.f=7",
                          "a.b=2 c.d=x e.f=9"));
  EXPECT_THAT(expanded({"a.b=9223372036854775806..9223372036854775807"}),
              ElementsAre("a.b=9223372036854775806", "a.b=9223372036854775807"));
  const auto combinations = expand_sets(Texts{"sampler.seed=1..20"});
  ASSERT_TRUE(combinations.ok());
  ASSERT_EQ(combinations.value().size(), 20U);
  EXPECT_EQ(std::get<std::int64_t>(combinations.value()[19][0].value.held), 20);
  EXPECT_THAT(expanded({"a.b={[1,2],[3]}"}), ElementsAre("a.b=[1,2]", "a.b=[3]"));
  EXPECT_THAT(expanded({"a.b=\"1..2\""}), ElementsAre("a.b=\"1..2\""));
}

TEST(Ranges, HaveALimitThatIsNamed) {
  EXPECT_EQ(expanded({"a.b=1..10000"}).size(), k_combinations_max);
  const std::string limit = ": |10000 requests";
  EXPECT_THAT(expanded({"a.b=1..10001"}),
              ElementsAre(tests::LinesHaveFacts("--set a.b=1..10001" + limit)));
  EXPECT_THAT(expanded({"a.b={0,1..10000}"}),
              ElementsAre(tests::LinesHaveFacts("--set a.b={0,1..10000}" + limit)));
  EXPECT_THAT(expanded({"a.b=1..101", "c.d=1..100"}),
              ElementsAre(tests::LinesHaveFacts("--set c.d=1..100" + limit)));
  EXPECT_THAT(expanded({"a.b=-9223372036854775808..9223372036854775807"}),
              ElementsAre(tests::LinesHaveFacts(
                  "--set a.b=-9223372036854775808..9223372036854775807" + limit)));
  EXPECT_THAT(expanded({"a.b=3..1"}),
              ElementsAre(tests::LinesHaveFacts("--set a.b=3..1: |3..1|empty")));
  EXPECT_THAT(expanded({"a.b={1,,2}"}),
              ElementsAre(tests::LinesHaveFacts("--set a.b={1,,2}: |empty item")));
  EXPECT_THAT(expanded({"a.b={}"}),
              ElementsAre(tests::LinesHaveFacts("--set a.b={}: |empty item")));
}

}  // namespace
}  // namespace sleight::request
