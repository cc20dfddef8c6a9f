// Goal: if any file call of a session fails, the error names the file and the reason. The old
// archive stays, or a complete archive replaces it. The next session has the digest of an
// undisturbed run. Method: run sessions on a file system in which each call fails in turn.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "common/archive/digest/verify.h"
#include "common/archive/hdf5/reader.h"
#include "common/base/error.h"
#include "common/store/sessions.h"
#include "service/coordinator/run.h"
#include "tests/support/facts.h"
#include "tests/support/property.h"
#include "tests/unit/common/base/faulty_file_system.h"
#include "tests/unit/service/coordinator/ball_runs.h"

namespace sleight::coordinator {
namespace {

using base::testing::Fault;
using base::testing::FaultyFileSystem;
using base::testing::FileCall;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

class RunRequestFaults : public testing::BallRuns {
 protected:
  std::string output() const { return path("ball.h5"); }

  /// Runs a session with this fault. Returns its error, or an empty string if the session
  /// succeeded.
  std::string failure_of(const Fault& fault, const std::string& request) {
    files_.fail(fault);
    try {
      // The order of a checkpoint's calls varies, so make no checkpoints.
      (void)session_on(files_, request, {.output = output(), .checkpoint_every_s = 0});
    } catch (const base::Error& error) {
      EXPECT_EQ(error.exit_code(), base::ExitCode::environment) << error.what();
      return error.what();
    }
    return {};
  }

  FaultyFileSystem files_;
};

TEST_F(RunRequestFaults, AnyCallMayFail) {
  // First, the disk becomes full at the k-th call and stays full, for each k. Then only the k-th
  // call fails, for every third k. The fast tier tries only every 25th and every 40th k. With
  // sanitizers, a session takes ten times as long, so try only every 15th and every 22nd k.
#ifdef SLEIGHT_SANITIZED
  const std::uint64_t for_good_every = 15, once_every = 22;
#else
  const std::uint64_t for_good_every = property::of_tier(25, 1);
  const std::uint64_t once_every = property::of_tier(40, 3);
#endif
  const std::string longer = request_text("scans = 60");
  const std::string expected = session(longer, {.output = path("s.h5")}).digest;
  (void)session(request_text("scans = 30"), {.output = path("t.h5")});
  for (const std::uint64_t step : {for_good_every, once_every}) {
    bool got_through = false;
    std::uint64_t call = 0;
    for (; !got_through; call += step) {
      SCOPED_TRACE(fmt::format("call {}, step {}", call, step));
      // An earlier, shorter run exists.
      std::filesystem::copy(path("t.h5"), output());
      std::filesystem::copy(run_folder(path("t.h5")), run_folder(output()));
      const std::string said = failure_of({.after = call,
                                           .times = step == for_good_every ? Fault::k_for_ever : 1,
                                           .reason = std::errc::no_space_on_device},
                                          longer);
      got_through = files_.failures() == 0;
      if (!said.empty()) {
        EXPECT_THAT(said, AllOf(HasSubstr(path("")), HasSubstr("No space left on device")));
      }
      EXPECT_THAT(archive::verify(*archive::hdf5::open_file(output())), IsEmpty());
      EXPECT_EQ(session(longer, {.output = output()}).digest, expected);
      std::filesystem::remove(output());
      std::filesystem::remove_all(run_folder(output()));
      EXPECT_THAT(names(), UnorderedElementsAre("s.h5", "s.h5.run", "t.h5", "t.h5.run"));
      ASSERT_FALSE(HasFailure());
    }
    EXPECT_GT(call, 15U);
  }
}

TEST_F(RunRequestFaults, NoPermissionIsSaidBeforeAnythingIsComputed) {
  // Goal: if the output can't be written, the session fails at once and leaves no files.
  EXPECT_THAT(failure_of({.call = FileCall::create, .reason = std::errc::permission_denied},
                         request_text("scans = 30")),
              tests::LinesHaveFacts(output() + ": |Permission denied"));
  EXPECT_THAT(names(), IsEmpty());
}

TEST_F(RunRequestFaults, AnArchiveThatFailsIsMadeFromTheStoreLater) {
  // Goal: if the archive can't be written, the results stay stored. The next session writes the
  // archive and computes nothing. Method: in each session, let one kind of call fail while the
  // archive is written.
  const std::string request = request_text("scans = 30");
  const std::string expected = session(request, {.output = path("s.h5")}).digest;
  for (const Fault& fault :
       {Fault{.call = FileCall::create, .after = 1, .reason = std::errc::permission_denied},
        Fault{.call = FileCall::write, .reason = std::errc::no_space_on_device},
        Fault{.call = FileCall::close, .reason = std::errc::io_error},
        Fault{.call = FileCall::sync_file, .reason = std::errc::io_error},
        Fault{.call = FileCall::rename, .reason = std::errc::permission_denied},
        Fault{.call = FileCall::sync_directory, .reason = std::errc::io_error}}) {
    SCOPED_TRACE(name_of(*fault.call));
    EXPECT_THAT(
        failure_of(fault, request),
        AllOf(HasSubstr(output()), HasSubstr(std::make_error_code(fault.reason).message())));
    EXPECT_EQ(std::filesystem::exists(output()), fault.call == FileCall::sync_directory);
    const auto sessions = store::sessions_of(run_folder(output()));
    ASSERT_TRUE(sessions.size() == 1 && sessions[0].end.has_value());
    EXPECT_EQ(sessions[0].end->end, events::End::failed);
    EXPECT_EQ(sessions[0].end->exit_code, base::ExitCode::environment);
    EXPECT_THAT(sessions[0].end->words, HasSubstr(output()));
    const RunSummary next = session(request, {.output = output()});
    EXPECT_EQ(next.progress.session_scans, 0U);
    EXPECT_EQ(next.digest, expected);
    std::filesystem::remove(output());
    std::filesystem::remove_all(run_folder(output()));
    EXPECT_THAT(names(), UnorderedElementsAre("s.h5", "s.h5.run"));
  }
}

TEST_F(RunRequestFaults, LeftoversThatStayStopNobody) {
  // Goal: a run deletes unfinished archives of a killed process. If the deletion fails, the run
  // continues. Method: leave two unfinished archives. Let a removal fail in one session. Let the
  // listing of the folder fail in the next session.
  const std::string request = request_text("scans = 30");
  const auto put_leftovers = [&] {
    put_bytes(path("ball.h5.tmp.11"), "half");
    put_bytes(path("ball.h5.tmp.12"), "half");
  };
  put_leftovers();
  EXPECT_EQ(failure_of({.call = FileCall::remove,
                        .after = 1,
                        .times = 1,
                        .reason = std::errc::permission_denied},
                       request),
            "");
  EXPECT_THAT(names(), UnorderedElementsAre("ball.h5", "ball.h5.run", "ball.h5.tmp.11"));
  put_leftovers();
  EXPECT_EQ(failure_of({.call = FileCall::list, .reason = std::errc::permission_denied}, request),
            "");
  EXPECT_THAT(names(), ::testing::Contains("ball.h5.tmp.12"));
  (void)session(request, {.output = output()});
  EXPECT_THAT(names(), UnorderedElementsAre("ball.h5", "ball.h5.run"));
}

}  // namespace
}  // namespace sleight::coordinator
