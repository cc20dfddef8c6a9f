// Whole runs on a network disk, which has no shared memory and no flock.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/store/lease_files.h"
#include "common/store/sessions.h"
#include "tests/unit/common/store/unshared_disk.h"
#include "tests/unit/service/coordinator/ball_runs.h"

namespace sleight::coordinator {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class NetworkRuns : public testing::BallRuns {
 protected:
  static RunOptions with_checkpoints(const std::string& output) {
    return {.output = output, .checkpoint_every_s = 0.02};
  }

  /// Rewrites the folder's lease, so that its holder seems to be on another machine.
  static void move_holder_to_another_node(const std::string& folder) {
    store::PosixLeaseFiles files(folder, store::this_process());
    const std::uint64_t newest = files.list().back();
    store::LeaseText lease = store::LeaseText::from_text(files.read(newest).value()).value();
    lease.holder.machine = "another";
    lease.lease_s = 1;
    put_bytes(folder + "/lease." + std::to_string(newest), lease.to_text());
  }
};

TEST_F(NetworkRuns, HaveTheDigestOfALocalDisk) {
  // Goal: if a run on a network disk is stopped and resumed, its archive equals that of a run on a
  // local disk. Method: run plain chains and ladders in two sessions of two threads, with
  // checkpoints. Compare the digests.
  const std::vector<std::string> texts{
      request_text("scans = 300", k_slow),
      request_text("rounds = 3", std::string(k_slow) + "replicas = 4\n", "parallel_tempering")};
  std::vector<std::string> digests;
  digests.reserve(texts.size());
  for (const std::string& text : texts)
    digests.push_back(session(text, {.output = path("local.h5"), .fresh = true}).digest);
  EXPECT_TRUE(std::filesystem::exists(path("local.h5.run/lock")));

  const store::testing::UnsharedDisk disk;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    const std::string output = path("network" + std::to_string(i) + ".h5");
    RunOptions stopped = with_checkpoints(output);
    stopped.stop_requested = stop_at(6);
    const RunSummary first = session(texts[i], stopped, 2);
    EXPECT_EQ(first.end, DriveEnd::stop_requested);
    const RunSummary second = session(texts[i], with_checkpoints(output), 2);
    EXPECT_EQ(second.epoch, 2U);
    EXPECT_EQ(second.digest, digests[i]);
    EXPECT_EQ(store::sessions_of(run_folder(output)).size(), 2U);
    EXPECT_FALSE(std::filesystem::exists(run_folder(output) + "/lock"));
    EXPECT_FALSE(std::filesystem::exists(run_folder(output) + "/store.sqlite-shm"));
  }
}

TEST_F(NetworkRuns, MakeCheckpointsOverTheWritersConnection) {
  // Goal: on a network disk, a run makes checkpoints while it commits results. Other readers get an
  // error that names the latest archive. Method: stop an endless run when an archive exists.
  const store::testing::UnsharedDisk disk;
  const std::string output = path("a.h5");
  std::string refusal;
  RunOptions options = with_checkpoints(output);
  options.stop_requested = [&] {
    if (!refusal.empty() || !std::filesystem::exists(output)) return !refusal.empty();
    try {
      (void)store::sessions_of(run_folder(output));
      refusal = "none";
    } catch (const base::Error& error) {
      refusal = error.what();
    }
    return true;
  };
  (void)session(request_text("scans = 100000000", k_slow), options, 2);
  EXPECT_THAT(refusal, AllOf(HasSubstr("network disk"), HasSubstr("latest archive, ")));
}

TEST_F(NetworkRuns, ARunIsTakenOverFromADeadNode) {
  // Goal: if a run's node dies, another node can resume the run and gets the digest of an
  // undisturbed run. Method: kill a child process after its first commits. Rewrite the child's
  // lease as another node's lease of one second.
  const std::string text = request_text("scans = 200", k_slow);
  const std::string expected = session(text, {.output = path("quiet.h5")}).digest;
  const store::testing::UnsharedDisk disk;
  const std::string output = path("a.h5");
  const std::string folder = run_folder(output);
  const pid_t node = ::fork();
  if (node == 0) {
    RunOptions options = with_checkpoints(output);
    options.hear = [](const events::RunEvent& event) {
      const auto* now = std::get_if<events::Progress>(&event.what);
      if (now != nullptr && now->scans_done > 30) ::raise(SIGKILL);
    };
    (void)session(text, options);
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(node, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  move_holder_to_another_node(folder);
  const RunSummary heir = session(text, with_checkpoints(output), 2);
  EXPECT_EQ(heir.epoch, 2U);
  EXPECT_EQ(heir.digest, expected);
}

}  // namespace
}  // namespace sleight::coordinator
