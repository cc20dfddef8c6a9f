#include "service/coordinator/derive.h"
#include "service/coordinator/run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <vector>

#include "common/archive/digest/digest.h"
#include "common/archive/digest/verify.h"
#include "common/archive/hdf5/reader.h"
#include "common/archive/summary.h"
#include "common/base/error.h"
#include "common/store/run_store.h"
#include "common/store/sessions.h"
#include "tests/unit/service/coordinator/ball_runs.h"

namespace sleight::coordinator {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

class RunRequest : public testing::BallRuns {
 protected:
  std::string output() const { return path("ball.h5"); }

  std::string conflict_of(const std::string& request, bool fresh = false) const {
    try {
      (void)session(request, {.output = output(), .fresh = fresh});
    } catch (const base::Error& error) {
      EXPECT_EQ(error.exit_code(), base::ExitCode::conflict) << error.what();
      return error.what();
    }
    ADD_FAILURE() << "no error";
    return {};
  }
};

TEST_F(RunRequest, FromRequestToArchive) {
  // Goal: one session writes a valid archive and returns its digest. Only the archive and the run's
  // folder remain.
  const RunSummary summary = session(request_text("scans = 200"), {.output = output()}, 2);
  EXPECT_EQ(summary.end, DriveEnd::finished);
  EXPECT_EQ(summary.scans, 200U);
  EXPECT_EQ(summary.epoch, 1U);
  EXPECT_EQ(summary.progress.scans_done, 600U);
  EXPECT_EQ(summary.progress.session_proposed, 3U * 199U);
  const auto archive = archive::hdf5::open_file(output());
  EXPECT_EQ(archive::digest(*archive), summary.digest);
  EXPECT_THAT(archive::verify(*archive), IsEmpty());
  EXPECT_THAT(names(), ::testing::UnorderedElementsAre("ball.h5", "ball.h5.run"));
}

TEST_F(RunRequest, SameCommandAgainDoesNothingNew) {
  // Goal: if a finished run's request runs again, the session computes nothing. If the archive was
  // deleted, the session writes the same bytes again.
  const RunSummary first = session(request_text("scans = 150"), {.output = output()});
  const std::string bytes = bytes_of(output());
  std::filesystem::remove(output());
  const RunSummary second = session(request_text("scans = 150"), {.output = output()});
  EXPECT_EQ(second.epoch, 2U);
  EXPECT_EQ(second.progress.session_scans, 0U);
  EXPECT_EQ(second.digest, first.digest);
  EXPECT_EQ(bytes_of(output()), bytes);
}

TEST_F(RunRequest, GoesOnWhereItStopped) {
  // Goal: if a run is resumed, or extended by a longer request, its archive equals an uninterrupted
  // run's archive. Method: stop a run early, finish it, then request more scans of it.
  const std::string shorter = request_text("scans = 300", k_slow);
  const std::string longer = request_text("scans = 500", k_slow);
  const RunSummary stopped = session(shorter, {.output = output(), .stop_requested = stop_at(6)});
  EXPECT_EQ(stopped.end, DriveEnd::stop_requested);
  EXPECT_LT(stopped.scans, 300U);
  const RunSummary finished = session(shorter, {.output = output()});
  EXPECT_EQ(finished.end, DriveEnd::finished);
  EXPECT_EQ(finished.epoch, 2U);
  const RunSummary more = session(longer, {.output = output()});
  EXPECT_EQ(more.progress.session_scans, 3U * 200U);
  EXPECT_EQ(session(shorter, {.output = path("a.h5")}).digest, finished.digest);
  EXPECT_EQ(session(longer, {.output = path("b.h5")}).digest, more.digest);
}

TEST_F(RunRequest, LeavesHowEachSessionEnded) {
  // Goal: each session's end is stored and reported once, with the archive's digest. This holds
  // even if the session fails after it opened the store. Method: run four sessions. Stop the first
  // session. Let the second session reach its time limit. Put a foreign file in the place of the
  // third session's archive. Finish the fourth session.
  const std::string request = request_text("scans = 300", k_slow);
  std::vector<events::RunEnd> heard;
  RunOptions options{.output = output(),
                     .ended = [&](const events::RunEnd& end) { heard.push_back(end); }};
  options.stop_requested = stop_at(6);
  const RunSummary stopped = session(request, options);
  options.stop_requested = {};
  options.time_limit_s = 1e-9;
  const RunSummary late = session(request, options);
  options.time_limit_s = 0;
  put_bytes(output(), "mine");
  EXPECT_THROW(session(request, options), base::Error);
  std::filesystem::remove(output());
  const RunSummary finished = session(request, options);

  ASSERT_EQ(heard.size(), 4U);
  EXPECT_EQ(heard[0], (events::RunEnd{.epoch = 1,
                                      .end = events::End::stop_requested,
                                      .exit_code = base::ExitCode::interrupted,
                                      .scans = stopped.scans,
                                      .solutions = stopped.progress.solutions,
                                      .digest = stopped.digest}));
  EXPECT_EQ(heard[1], (events::RunEnd{.epoch = 2,
                                      .end = events::End::time_limit,
                                      .scans = late.scans,
                                      .solutions = late.progress.solutions,
                                      .digest = late.digest}));
  EXPECT_EQ(heard[2].end, events::End::failed);
  EXPECT_EQ(heard[2].exit_code, base::ExitCode::conflict);
  EXPECT_THAT(heard[2].words, HasSubstr("not overwritten"));
  EXPECT_EQ(heard[3], (events::RunEnd{.epoch = 4,
                                      .end = events::End::finished,
                                      .scans = 300,
                                      .solutions = finished.progress.solutions,
                                      .digest = finished.digest}));
  const auto sessions = store::sessions_of(run_folder(output()));
  ASSERT_EQ(sessions.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_EQ(sessions[i].end, heard[i]);
}

TEST_F(RunRequest, StoppedArchiveIsThatOfFewerScans) {
  // Goal: if a run is stopped after n scans, its archive equals that of a run that requests n scans
  // (C1), even if the store has more scans. Method: compare a stopped run with a new run of the
  // request in its archive. Then request fewer scans of a finished run, and compare with a new run
  // of as many scans.
  const RunSummary stopped = session(request_text("independent_solutions = 3\nscans = 100000"),
                                     {.output = output(), .stop_requested = stop_at(3)}, 2);
  ASSERT_GT(stopped.scans, 0U);
  const std::string exact = archive::summary_of(*archive::hdf5::open_file(output())).request_text;
  EXPECT_THAT(exact, HasSubstr("[stop]\nscans = " + std::to_string(stopped.scans) + "\n"));
  EXPECT_EQ(session(exact, {.output = path("exact.h5")}).digest, stopped.digest);

  const RunSummary whole = session(request_text("scans = 400"), {.output = path("w.h5")});
  EXPECT_EQ(whole.scans, 400U);
  const RunSummary cut = session(request_text("scans = 123"), {.output = path("w.h5")});
  EXPECT_EQ(cut.scans, 123U);
  EXPECT_EQ(cut.progress.session_scans, 0U);
  EXPECT_EQ(session(request_text("scans = 123"), {.output = path("c.h5")}).digest, cut.digest);
}

TEST_F(RunRequest, StoppedBeforeAnythingWritesNoArchive) {
  // Goal: a run that is stopped before it has results writes no archive, and can be resumed.
  const RunSummary summary =
      session(request_text("scans = 50"), {.output = output(), .stop_requested = stop_at(1)});
  EXPECT_EQ(summary.scans, 0U);
  EXPECT_EQ(summary.digest, "");
  EXPECT_FALSE(std::filesystem::exists(output()));
  EXPECT_EQ(session(request_text("scans = 50"), {.output = output()}).scans, 50U);
}

TEST_F(RunRequest, AnotherRequestIsRefused) {
  // Goal: a request never overwrites another request's output. Method: change one option of the
  // sampler or the constraint. The request must be refused, and the archive and the run must stay
  // unchanged.
  const RunSummary first = session(request_text("scans = 60"), {.output = output()});
  const std::string bytes = bytes_of(output());
  for (const std::string& other :
       {request_text("scans = 60", "iterations_per_scan = 2\n"),
        request_text("scans = 60") + "[constraint]\ntarget_diameters = 2\n",
        request_text("scans = 60", "change_probability = 0.25\n")}) {
    EXPECT_THAT(conflict_of(other), AllOf(HasSubstr(output()), HasSubstr("another request")));
    EXPECT_EQ(bytes_of(output()), bytes);
  }
  EXPECT_EQ(session(request_text("scans = 60"), {.output = output()}).digest, first.digest);
}

TEST_F(RunRequest, FreshStartsOver) {
  // Goal: --fresh deletes an earlier run of any request. If there is no earlier run, --fresh has no
  // effect. Method: use --fresh three times: without a run, on another request's run, and on the
  // same request's run.
  const std::string other = request_text("scans = 40", "change_probability = 0.25\n");
  EXPECT_EQ(session(other, {.output = output(), .fresh = true}).epoch, 1U);
  const RunSummary fresh = session(request_text("scans = 60"), {.output = output(), .fresh = true});
  EXPECT_EQ(fresh.epoch, 1U);
  EXPECT_EQ(fresh.progress.session_scans, 180U);
  EXPECT_EQ(session(request_text("scans = 60"), {.output = path("a.h5")}).digest, fresh.digest);
  const RunSummary again = session(request_text("scans = 60"), {.output = output(), .fresh = true});
  EXPECT_EQ(again.progress.session_scans, 180U);
  EXPECT_EQ(again.digest, fresh.digest);
}

TEST_F(RunRequest, FreshGivesUpAStoreOfAKilledProcess) {
  // Goal: if a process ends while it deletes a store, the next run doesn't use the remaining files.
  // Method: make a run folder that has no database. Put another run's write-ahead log and the log's
  // index into it.
  (void)session(request_text("scans = 200"), {.output = path("other.h5")});
  std::filesystem::create_directory(path("ball.h5.run"));
  const std::string target = store::RunStore::database_path(path("ball.h5.run"));
  {
    const store::RunLock lock(path("other.h5.run"));
    store::Database open(store::RunStore::database_path(path("other.h5.run")),
                         store::Access::read_write);
    open.execute("UPDATE run SET value=7 WHERE key='epoch'");
    for (const char* suffix : {"-wal", "-shm"}) {
      put_bytes(target + suffix,
                bytes_of(store::RunStore::database_path(path("other.h5.run")) + suffix));
    }
  }
  ASSERT_GT(std::filesystem::file_size(target + "-wal"), 0U);
  const RunSummary summary = session(request_text("scans = 60"), {.output = output()});
  EXPECT_EQ(summary.epoch, 1U);
  EXPECT_EQ(summary.progress.session_scans, 180U);
}

TEST_F(RunRequest, ForeignFileIsNotTouched) {
  // Goal: if the output's path is a foreign file, the file stays, even with --fresh. No file is
  // created beside it. Method: use a text file as the output. Then add an empty run folder.
  put_bytes(output(), "my thesis");
  for (const bool fresh : {false, true}) {
    EXPECT_THAT(conflict_of(request_text("scans = 5"), fresh),
                AllOf(HasSubstr(output()), HasSubstr("not overwritten")));
  }
  EXPECT_THAT(names(), ::testing::ElementsAre("ball.h5"));
  std::filesystem::create_directory(run_folder(output()));
  (void)conflict_of(request_text("scans = 5"), true);
  EXPECT_EQ(bytes_of(output()), "my thesis");
}

TEST_F(RunRequest, RunningRunIsNotDisturbed) {
  // Goal: while a process holds a run's lock, other sessions are refused and change no file, even
  // with --fresh.
  (void)session(request_text("scans = 30"), {.output = output()});
  const std::string bytes = bytes_of(output());
  const store::RunLock lock(run_folder(output()));
  for (const bool fresh : {false, true}) {
    EXPECT_THAT(conflict_of(request_text("scans = 30"), fresh), HasSubstr("another process"));
  }
  EXPECT_EQ(bytes_of(output()), bytes);
  EXPECT_TRUE(std::filesystem::exists(store::RunStore::database_path(run_folder(output()))));
}

TEST_F(RunRequest, CheckpointsAreArchivesOfTheirScans) {
  // Goal: each archive of an unfinished run is complete. If the archive has n scans, it equals the
  // archive of a run of n scans. Method: make checkpoints as often as possible. Compare copies of
  // two checkpoints with the archives of such runs. With sanitizers, checkpoints are rare, so
  // compare one copy.
#ifdef SLEIGHT_SANITIZED
  constexpr std::size_t k_copies = 1;
#else
  constexpr std::size_t k_copies = 2;
#endif
  std::vector<std::string> copies;
  std::filesystem::file_time_type last{};
  const auto copy_new_one = [&] {
    if (!std::filesystem::exists(output())) return false;
    const auto written = std::filesystem::last_write_time(output());
    if (written == last) return false;
    last = written;
    copies.push_back(path("copy" + std::to_string(copies.size()) + ".h5"));
    std::filesystem::copy(output(), copies.back());
    return copies.size() == k_copies;
  };
  (void)session(request_text("scans = 100000000", k_slow), {.output = output(),
                                                            .time_limit_s = 60,
                                                            .stop_requested = copy_new_one,
                                                            .checkpoint_every_s = 1e-3});
  ASSERT_EQ(copies.size(), k_copies);
  std::uint64_t before = 0;
  for (const std::string& copy : copies) {
    const auto open = archive::hdf5::open_file(copy);
    EXPECT_THAT(archive::verify(*open), IsEmpty());
    const archive::Summary summary = archive::summary_of(*open);
    const std::uint64_t scans = summary.scans;
    EXPECT_GT(scans, before);
    before = scans;
    const std::string& exact = summary.request_text;
    const std::string straight = path("exact" + std::to_string(scans) + ".h5");
    EXPECT_EQ(session(exact, {.output = straight, .checkpoint_every_s = 0}).digest,
              archive::digest(*open));
  }
}

TEST_F(RunRequest, IdentityIsWhatDecidesTheStoredResults) {
  // Goal: two requests have the same identity if and only if their stored results agree. Method:
  // change one key of a request at a time.
  const auto identity = [](const std::string& text) {
    const run::Catalogue catalogue;
    return run_identity(request::read_request(text, "r", catalogue.bindings()).value());
  };
  const std::string base = identity(request_text("scans = 5"));
  EXPECT_EQ(identity(request_text("rounds = 3")), base);
  std::string kept = request_text("scans = 5");
  kept.replace(kept.find("keep_max = 50"), 13, "keep_max = 7 ");
  EXPECT_EQ(identity(kept), base);
  std::string thin = request_text("scans = 5");
  thin.replace(thin.find("thin = 3"), 8, "thin = 4");
  EXPECT_NE(identity(thin), base);
  std::string seed = request_text("scans = 5");
  seed.replace(seed.find("seed = 17"), 9, "seed = 18");
  EXPECT_NE(identity(seed), base);
  EXPECT_NE(identity(request_text("scans = 5", "iterations_per_scan = 2\n")), base);
}

}  // namespace
}  // namespace sleight::coordinator
