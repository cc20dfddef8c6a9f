// Goal: a program's time and output are limited, and it leaves no processes.
#include "service/keeper/tool.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <string>

#include "common/base/error.h"
#include "service/keeper/command.h"

namespace sleight::keeper {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

ToolEnd run_shell(const std::string& script, ToolOptions options = {}) {
  options.environment = whole_environment();
  return run_tool({"sh", "-c", script}, options);
}

TEST(Tools, TellWhatTheyPrintAndHowTheyEnd) {
  const ToolEnd end = run_shell("cat; echo word >&2; exit 3", {.input = std::string(300'000, 'x')});
  EXPECT_EQ(end.exit_code, 3);
  EXPECT_EQ(end.output, std::string(300'000, 'x'));
  EXPECT_EQ(end.words, "word");
  EXPECT_EQ(end.why(), "word");
  EXPECT_FALSE(end.is_cut);
  EXPECT_EQ(run_shell("exit 4").why(), "the command exited with code 4");
  EXPECT_EQ(run_shell("kill -9 $$").exit_code, -1);
}

TEST(Tools, WordsSteerNoTerminal) {
  const ToolEnd end = run_shell("printf 'a\\033[2J\\tb\\r\\177c\\nd \\n' >&2; exit 1");
  EXPECT_EQ(end.words, "a?[2J b??c\nd");
  EXPECT_EQ(end.why(), "a?[2J b??c d");
}

TEST(Tools, AtALowPriority) {
  EXPECT_EQ(run_shell("nice", {.yields = true}).output, "10\n");
}

TEST(Tools, AreBounded) {
  const ToolEnd end = run_shell("head -c 100000 /dev/zero; head -c 100000 /dev/zero >&2",
                                {.output_bytes_max = 1000, .words_bytes_max = 500});
  EXPECT_TRUE(end.is_cut);
  EXPECT_EQ(end.output.size(), 1000U);
  EXPECT_LE(end.words.size(), 500U);
}

TEST(Tools, ThatTakeTooLongAreKilled) {
  // Method: run three programs. One program waits, one has a child that keeps the output open, and
  // one closes its output and waits. Without a time limit, each program would take 1,000 s.
  for (const char* script : {"sleep 1000", "sleep 1000 & exit 0", "exec >&- 2>&-; sleep 1000"})
    EXPECT_TRUE(run_shell(script, {.seconds_max = 0.2}).was_too_slow) << script;
  const std::atomic<bool> stop = true;
  EXPECT_TRUE(run_shell("sleep 1000", {.stop = &stop}).was_too_slow);
}

TEST(Tools, ThatReadNothingEndNobody) {
  const ToolEnd end = run_shell("exec <&-; echo done", {.input = std::string(1'000'000, 'x')});
  EXPECT_EQ(end.exit_code, 0);
  EXPECT_EQ(end.output, "done\n");
}

TEST(Tools, ThatAreNotThereCannotBeStarted) {
  EXPECT_THROW(run_tool({"sleight-no-such-program"}, {}), base::Error);
}

TEST(Tools, EnvironmentsLackWhatTheyAreToLack) {
  ::setenv("SLURM_CONF", "c", 1);
  ::setenv("SLURM_JOB_ID", "7", 1);
  const auto variables = environment_without({"SLURM_"}, {"SLURM_CONF"});
  EXPECT_THAT(variables, Contains("SLURM_CONF=c"));
  EXPECT_THAT(variables, Not(Contains(HasSubstr("SLURM_JOB_ID"))));
  ::unsetenv("SLURM_CONF");
  ::unsetenv("SLURM_JOB_ID");
}

}  // namespace
}  // namespace sleight::keeper
