// Goal: the daemon starts programs with the right commands and environments.
#include "service/keeper/command.h"

#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace sleight::keeper {
namespace {

const Programs k_programs{.keeper = "/b/sleight-keeper",
                          .sleight = "/b/sleight",
                          .sleight_batch = "/b/sleight-batch",
                          .mpirun = "/usr/bin/mpirun"};

std::string joined(const std::vector<std::string>& words) {
  return fmt::format("{}", fmt::join(words, " "));
}

TEST(Command, WithoutRanksNoMpiIsStarted) {
  const AttemptSpec spec{
      .folder = "/jobs/17", .attempt = 3, .cores = 2, .cache_mb = 64, .strict = true};
  EXPECT_EQ(
      joined(command_of(spec, k_programs)),
      "/b/sleight direct request.toml -o out.h5 -j 2 --cache 64 --end-report end.pipe --quiet "
      "--strict");
  EXPECT_EQ(joined(keeper_command_of(spec, k_programs)),
            "/b/sleight-keeper --folder /jobs/17 --attempt 3 --grace 30 -- " +
                joined(command_of(spec, k_programs)));
}

TEST(Command, WithRanksOpenMpiKeepsToTheFolder) {
  // Method: compare the whole command line. If an attempt has more ranks than this machine has
  // cores, it must be refused.
  AttemptSpec spec{.folder = "/jobs/1 7", .ranks = 3, .grace_s = 0.5};
  EXPECT_EQ(
      joined(command_of(spec, k_programs)),
      "/usr/bin/mpirun --bind-to none --mca plm isolated --mca btl self,vader "
      "--mca oob_tcp_if_include lo --mca orte_tmpdir_base /jobs/1 7/mpi --mca "
      "btl_vader_backing_directory /jobs/1 7/mpi -n 3 /b/sleight-batch request.toml -o out.h5 "
      "--cache 256 --end-report end.pipe --quiet");
  EXPECT_EQ(joined(keeper_command_of(spec, k_programs)),
            "/b/sleight-keeper --folder /jobs/1 7 --attempt 1 --grace 0.5 --ranks -- " +
                joined(command_of(spec, k_programs)));
  spec.ranks = 1;
  EXPECT_EQ(obstacle_of(spec, k_programs), "");
  spec.ranks = 100'000;
  EXPECT_NE(obstacle_of(spec, k_programs).find("100000 ranks"), std::string::npos);
  Programs without = k_programs;
  without.mpirun.clear();
  EXPECT_NE(obstacle_of(spec, without).find("mpirun is not on the PATH"), std::string::npos);
  spec.ranks = 0;
  EXPECT_EQ(obstacle_of(spec, without), "");
  spec.folder = "jobs/17";
  EXPECT_NE(obstacle_of(spec, without), "");
}

TEST(Command, InABatchSystemsJobMpirunHasThatJobsMachines) {
  // Goal: inside a batch system's job, this machine's cores and mpirun don't matter.
  AttemptSpec spec{.folder = "/jobs/17", .ranks = 100'000, .in_batch = true};
  EXPECT_EQ(obstacle_of(spec, k_programs), "");
  EXPECT_EQ(joined(command_of(spec, k_programs)),
            "/usr/bin/mpirun -n 100000 /b/sleight-batch request.toml -o out.h5 --cache 256 "
            "--end-report end.pipe --quiet");
  EXPECT_EQ(joined(keeper_command_of(spec, k_programs)),
            "/b/sleight-keeper --folder /jobs/17 --attempt 1 --grace 30 --ranks --batch -- " +
                joined(command_of(spec, k_programs)));
  Programs without = k_programs;
  without.mpirun.clear();
  EXPECT_EQ(obstacle_of(spec, without), "");
  EXPECT_EQ(command_of(spec, without).front(), "mpirun");
}

TEST(Command, TheEnvironmentIsCleaned) {
  // Method: set one variable of each kind that must be removed. Set variables that have similar
  // names and must stay.
  const std::vector<std::string> all{
      "PATH=/bin",        "OMPI_MCA_btl=tcp", "OMPI_ALLOW_RUN_AS_ROOT=1",
      "PMIX_RANK=3",      "LD_PRELOAD=x.so",  "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1",
      "SLURM_NODELIST=n", "OLD_=1",           "LDFLAGS=-x",
      "PMI_RANK=1",       "HOME=/root"};
  EXPECT_EQ(cleaned_environment(all),
            (std::vector<std::string>{"PATH=/bin", "OMPI_ALLOW_RUN_AS_ROOT=1",
                                      "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1", "OLD_=1", "LDFLAGS=-x",
                                      "HOME=/root"}));
}

}  // namespace
}  // namespace sleight::keeper
