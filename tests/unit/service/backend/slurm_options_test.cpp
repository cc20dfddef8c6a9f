// Goal: a job's Slurm options become arguments of sbatch. If an option would break the service, it
// is refused, even if its name is abbreviated.
#include "service/backend/slurm_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace sleight::backend {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string refusal_of(const Options& options) {
  try {
    slurm_wishes_of({}, options);
  } catch (const base::Error& error) {
    EXPECT_EQ(error.exit_code(), base::ExitCode::usage);
    return error.what();
  }
  return "taken";
}

TEST(SlurmOptions, OfAJobComeOverTheDefaults) {
  EXPECT_THAT(slurm_wishes_of({}, {}).arguments, IsEmpty());
  const Options defaults{{"account", "physics"},
                         {"partition", "long"},
                         {"more", " --constraint=avx512  --exclusive "}};
  EXPECT_THAT(
      slurm_wishes_of(defaults, {}).arguments,
      ElementsAre("--account=physics", "--partition=long", "--constraint=avx512", "--exclusive"));
  EXPECT_THAT(
      slurm_wishes_of(defaults, {{"partition", "short; rm"}, {"time", "1-0"}, {"more", "--nice=5"}})
          .arguments,
      ElementsAre("--account=physics", "--partition=short; rm", "--time=1-0", "--constraint=avx512",
                  "--exclusive", "--nice=5"));
  EXPECT_THAT(slurm_wishes_of(defaults, {{"account", ""}}).arguments,
              testing::Contains("--account=physics"));
}

TEST(SlurmOptions, SayWhetherTheyAskForMemory) {
  EXPECT_FALSE(slurm_wishes_of({}, {{"more", "--exclusive"}}).says_memory);
  EXPECT_TRUE(slurm_wishes_of({{"more", "--mem=0"}}, {}).says_memory);
  EXPECT_TRUE(slurm_wishes_of({}, {{"more", "--mem-per-cpu=2G"}}).says_memory);
}

TEST(SlurmOptions, ThatTheServiceSaysItselfAreRefused) {
  for (const char* word :
       {"--comment=x", "--comm=x", "--requeue", "--req", "--no-requeue", "--wrap=id", "--chdir=/",
        "--array=1-9", "--output=x", "--error=x", "--signal=9", "--open-mode=truncate", "--wait",
        "--test-only", "--clusters=all", "--job-name=x", "--ntasks=9", "--hold", "--uid=0"})
    EXPECT_THAT(refusal_of({{"more", std::string("--exclusive ") + word}}),
                HasSubstr("the service controls"))
        << word;
  EXPECT_EQ(refusal_of({{"more", "--wait-all-nodes=1 --ntasks-per-node=4"}}), "taken");
}

TEST(SlurmOptions, ThatAreNoneAreRefused) {
  for (const char* words : {"-p long", "--constraint a100", "exclusive", "--", "-"})
    EXPECT_THAT(refusal_of({{"more", words}}), HasSubstr("not an sbatch option")) << words;
  EXPECT_THAT(refusal_of({{"more", "--a=b\n--c"}}), HasSubstr("control characters"));
  EXPECT_THAT(refusal_of({{"account", "a\x7f"}}), HasSubstr("control characters"));
  EXPECT_THAT(refusal_of({{"account", std::string(2000, 'a')}}), HasSubstr("longer"));
  EXPECT_THAT(refusal_of({{"colour", "red"}}), HasSubstr("'colour'"));
}

}  // namespace
}  // namespace sleight::backend
