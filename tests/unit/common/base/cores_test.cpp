#include "common/base/cores.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <filesystem>

#include "common/base/file_system.h"
#include "tests/unit/common/archive/hdf5/scratch.h"

namespace sleight::base {
namespace {

class Cores : public archive::testing::Scratch {
 protected:
  void say(const std::string& name, const std::string& text) {
    std::filesystem::create_directories(std::filesystem::path(path(name)).parent_path());
    PosixFileSystem files;
    write_text_file(files, path(name), text);
  }
};

TEST_F(Cores, AreNoMoreThanAQuotaPaysFor) {
  // Goal: core_quota() returns the lowest of the quotas of a control group and its ancestors. Both
  // versions of control groups work. Method: write files in the kernel's format to a folder.
  const auto quota = [&](const char* groups) { return core_quota(groups, path("")); };
  EXPECT_EQ(quota("0::/a/b\n"), std::nullopt);
  say("cpu.max", "max 100000\n");
  say("a/b/cpu.max", "max 100000\n");
  EXPECT_EQ(quota("0::/a/b\n"), std::nullopt);
  say("a/cpu.max", "250000 100000\n");
  EXPECT_EQ(quota("0::/a/b\n"), 3U);
  EXPECT_EQ(quota("0::/\n"), std::nullopt);
  say("a/b/cpu.max", "1000 100000\n");
  EXPECT_EQ(quota("0::/a/b\n"), 1U);
  // Inside a container, the root folder describes the container's own group.
  say("cpu.max", "200000 100000\n");
  EXPECT_EQ(quota("0::/docker/17\n"), 2U);
  EXPECT_EQ(quota("nonsense\n0\n"), std::nullopt);

  const char* const old = "5:cpuset:/x\n4:cpu,cpuacct:/job\n1:name=systemd:/y\n";
  EXPECT_EQ(quota(old), std::nullopt);
  say("cpuset/x/cpu.cfs_quota_us", "100000\n");
  say("cpuset/x/cpu.cfs_period_us", "100000\n");
  say("cpu,cpuacct/job/cpu.cfs_quota_us", "-1\n");
  say("cpu,cpuacct/job/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(quota(old), std::nullopt);
  say("cpu,cpuacct/job/cpu.cfs_quota_us", "400000\n");
  EXPECT_EQ(quota(old), 4U);
}

TEST(CoresHere, AreThoseOfTheAffinity) {
  // Goal: if a process is bound to one core, cores_here() returns 1.
  cpu_set_t all;
  ASSERT_EQ(::sched_getaffinity(0, sizeof(all), &all), 0);
  int first = 0;
  while (!CPU_ISSET(first, &all))
    ++first;
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(first, &one);
  EXPECT_LE(cores_here(), static_cast<std::uint32_t>(CPU_COUNT(&all)));
  ASSERT_EQ(::sched_setaffinity(0, sizeof(one), &one), 0);
  EXPECT_EQ(cores_here(), 1U);
  ASSERT_EQ(::sched_setaffinity(0, sizeof(all), &all), 0);
}

}  // namespace
}  // namespace sleight::base
