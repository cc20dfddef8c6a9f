// Deriving an archive from a store reproduces the run's own archive.
#include "service/coordinator/derive.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "common/archive/remembering_reader.h"
#include "common/store/stored_run.h"
#include "tests/unit/service/coordinator/ball_runs.h"

namespace sleight::coordinator {
namespace {

/// Counts how often each state's motion is simulated.
class CountingReader final : public archive::ForwardingReader {
 public:
  using ForwardingReader::ForwardingReader;
  archive::Motion play(base::BytesView state) const override {
    {
      const std::scoped_lock lock(mutex_);
      ++plays_[base::Bytes(state.begin(), state.end())];
    }
    return ForwardingReader::play(state);
  }
  std::map<base::Bytes, int> plays() const {
    const std::scoped_lock lock(mutex_);
    return plays_;
  }

 private:
  mutable std::mutex mutex_;
  mutable std::map<base::Bytes, int> plays_;
};

class DeriveArchive : public testing::BallRuns {
 protected:
  /// Derives an archive of a run's current results from the run's folder alone.
  static std::string derived(const std::string& text, const std::string& output,
                             const std::string& place, const std::function<bool()>& stop = {}) {
    const run::Catalogue catalogue;
    const auto request = request::read_request(text, "request.toml", catalogue.bindings()).value();
    const run::WorldEntry& world = catalogue.world_of(request);
    const auto reader = world.make_reader(request);
    const std::function<std::unique_ptr<plan::Plan>(const request::Cut&)> plan_of =
        [&](const request::Cut& cut) { return run::make_plan(request, world, cut); };
    base::PosixFileSystem files;
    const auto plan = run::make_plan(request, world);
    request::Cut cut = committed_cut(run_folder(output), *plan);
    const std::string results_version = "results of tests";
    return derive_archive({.request = request,
                           .reader = *reader,
                           .plan_of = plan_of,
                           .files = files,
                           .results_version = results_version},
                          run_folder(output), place, cut, stop);
  }
};

TEST_F(DeriveArchive, IsTheRunsOwn) {
  // Goal: if an archive is derived from a run's folder alone, it equals the run's own archive byte
  // for byte. This holds for each kind of method, and for finished and stopped runs. This also
  // holds if the archive has fewer scans than the store. Method: run each request with two threads,
  // once to its end and once with an early stop.
  const auto word = [](const std::string& sampler, const std::string& stop) {
    return "[world]\nname = \"spelling\"\nbitmap = \"#.#\"\n[sampler]\nseed = 5\n" + sampler +
           "[stop]\n" + stop;
  };
  int nth = 0;
  for (const std::string& text :
       {request_text("scans = 200"), request_text("independent_solutions = 3\nscans = 100000"),
        request_text("scans = 150", "replicas = 4\n", "parallel_tempering"),
        request_text("rounds = 3", "replicas = 4\n", "parallel_tempering"),
        word("method = \"search\"\n", "found = 20\n"),
        word("method = \"sequential\"\nchains = 2\nparticles = 8\nround_scans = 4\n",
             "scans = 20\n"),
        word("method = \"sequential\"\nchains = 2\nparticles = 8\ntour_scans = 3\n",
             "independent_solutions = 2\nscans = 60\n")}) {
    SCOPED_TRACE(text);
    for (const std::uint64_t question : {3U, 0U}) {
      const std::string output = path("run" + std::to_string(nth++) + ".h5");
      RunOptions options{.output = output, .checkpoint_every_s = 0};
      if (question > 0) options.stop_requested = stop_at(question);
      const RunSummary run = session(text, options, 2);
      const std::string place = path("derived.h5");
      std::filesystem::remove(place);
      EXPECT_EQ(derived(text, output, place), run.digest);
      EXPECT_EQ(std::filesystem::exists(place), !run.digest.empty());
      if (!run.digest.empty()) {
        EXPECT_EQ(bytes_of(place), bytes_of(output));
      }
    }
  }
  const std::string output = path("longer.h5");
  (void)session(request_text("scans = 400"), {.output = output});
  const RunSummary shorter = session(request_text("scans = 123"), {.output = output});
  EXPECT_EQ(derived(request_text("scans = 123"), output, path("d.h5")), shorter.digest);
}

TEST_F(DeriveArchive, HangsOnItsCutAlone) {
  // Goal: the archive of a run's first scans doesn't depend on later scans, even if ladders get
  // more levels later. Method: derive an archive of the first 40 scans of a run of 2000 scans.
  // Compare it with the archive of a new run of 40 scans.
  const auto text = [](int scans) {
    return request_text("scans = " + std::to_string(scans), "", "parallel_tempering");
  };
  const RunSummary longer = session(text(2000), {.output = path("longer.h5")});
  const RunSummary cut = session(text(40), {.output = path("longer.h5")});
  const RunSummary fresh = session(text(40), {.output = path("fresh.h5")});
  EXPECT_EQ(cut.digest, fresh.digest);
  EXPECT_EQ(derived(text(40), path("longer.h5"), path("d.h5")), fresh.digest);
  const auto replicas = [&](const std::string& file, std::uint64_t scans) {
    return store::StoredRun(run_folder(path(file)), {.chains = 3, .scans = scans}).replicas();
  };
  EXPECT_GT(replicas("longer.h5", 2000), replicas("longer.h5", 40));
  EXPECT_EQ(replicas("longer.h5", 40), replicas("fresh.h5", 40));
}

TEST_F(DeriveArchive, EachMotionIsSimulatedOnce) {
  // Goal: a run simulates each kept animation's motion only once for all checkpoints and archives,
  // even if the run is resumed. Method: run with very frequent checkpoints, then resume the run.
  // Count the simulated motions.
  const run::Catalogue catalogue;
  const auto read = [&](const std::string& stop) {
    return request::read_request(
               "[world]\nname = \"spelling\"\nbitmap = \"#.#\"\n[sampler]\nseed = 5\n"
               "method = \"parallel_tempering\"\nchains = 2\nreplicas = 4\n[stop]\n" +
                   stop + "\n[output]\nkeep_per_lineage = 2\n",
               "request.toml", catalogue.bindings())
        .value();
  };
  std::optional<CountingReader> counted;
  std::unique_ptr<archive::StateReader> plain;
  const auto run_once = [&](const request::DirectionRequest& request, double time_limit_s) {
    const run::WorldEntry& world = catalogue.world_of(request);
    const auto worker = world.make_worker(request);
    if (!counted) {
      plain = world.make_reader(request);
      counted.emplace(*plain);
    }
    const auto plan = run::make_plan(request, world);
    const base::SteadyClock clock;
    base::PosixFileSystem files;
    const sampling::BlockRunner runner(*worker, clock);
    LocalCrew crew(runner, 1);
    return run_request(
        {.request = request,
         .reader = *counted,
         .plan = *plan,
         .plan_of = [&](const request::Cut& cut) { return run::make_plan(request, world, cut); },
         .crew = crew,
         .clock = clock,
         .files = files,
         .results_version = "results of tests"},
        {.output = path("run.h5"), .time_limit_s = time_limit_s, .checkpoint_every_s = 0.01});
  };
  const auto request = read("scans = 100000000");
  (void)run_once(request, 2.5);
  const std::size_t after_first = counted->plays().size();
  EXPECT_GT(after_first, 5U);
  (void)run_once(request, 1.5);
  EXPECT_GT(counted->plays().size(), after_first);
  for (const auto& [state, plays] : counted->plays())
    EXPECT_EQ(plays, 1);
}

TEST_F(DeriveArchive, CanBeStopped) {
  // Goal: if a derivation is stopped, the old archive stays and no new file is left.
  const std::string text = request_text("scans = 200");
  (void)session(text, {.output = path("run.h5")});
  const auto stop = [] { return true; };
  const std::string before = bytes_of(path("run.h5"));
  EXPECT_THROW(derived(text, path("run.h5"), path("run.h5"), stop), DeriveStopped);
  EXPECT_EQ(bytes_of(path("run.h5")), before);
  EXPECT_THAT(names(), ::testing::UnorderedElementsAre("run.h5", "run.h5.run"));
}

TEST_F(DeriveArchive, ARunThatIsToldToStopWhileItWritesKeepsTheOldOne) {
  // Goal: if a session is stopped while it writes its archive, the old archive stays and the store
  // is complete. The session ends as interrupted. The next session of the same request writes the
  // archive. Method: request a stop when the run reports that it begins to write the archive. Use a
  // new run. Then use a run that has an archive.
  const std::string text = request_text("scans = 200");
  const std::string longer = request_text("scans = 300");
  for (const bool has_archive : {false, true}) {
    const std::string output = path(has_archive ? "second.h5" : "first.h5");
    if (has_archive) (void)session(text, {.output = output});
    const std::string before = has_archive ? bytes_of(output) : std::string();
    bool is_writing = false;
    const auto hear = [&](const events::RunEvent& event) {
      const auto* phase = std::get_if<events::Phase>(&event.what);
      is_writing = is_writing || (phase != nullptr && phase->words == "writing the archive");
    };
    const RunSummary stopped = session(
        longer, {.output = output, .stop_requested = [&] { return is_writing; }, .hear = hear});
    EXPECT_TRUE(is_writing);
    EXPECT_EQ(stopped.end, DriveEnd::stop_requested);
    EXPECT_TRUE(stopped.is_archive_given_up);
    EXPECT_EQ(stopped.digest, "");
    EXPECT_EQ(stopped.scans, 300U);
    EXPECT_EQ(base::PosixFileSystem().exists(output), has_archive);
    if (has_archive) {
      EXPECT_EQ(bytes_of(output), before);
    }
    const RunSummary again = session(longer, {.output = output});
    EXPECT_EQ(again.end, DriveEnd::finished);
    EXPECT_FALSE(again.is_archive_given_up);
    EXPECT_EQ(again.progress.session_scans, 0U);
    EXPECT_EQ(again.digest, session(longer, {.output = path("whole.h5"), .fresh = true}).digest);
  }
}

}  // namespace
}  // namespace sleight::coordinator
