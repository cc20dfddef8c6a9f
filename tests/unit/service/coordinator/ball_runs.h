// Whole runs of the 2D ball in a scratch folder. Each session assembles its own parts.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include "common/base/clock.h"
#include "common/base/file_system.h"
#include "service/coordinator/local_crew.h"
#include "service/coordinator/run.h"
#include "tests/unit/common/archive/hdf5/scratch.h"
#include "worker/run/catalogue.h"
#include "worker/sampling/block_runner.h"

namespace sleight::coordinator::testing {

class BallRuns : public archive::testing::Scratch {
 protected:
  /// For request_text(): scans become so slow that a session can be stopped between two units.
  static constexpr const char* k_slow = "iterations_per_scan = 200\n";

  /// Returns a request for three chains or ladders. `stop` is the content of [stop]; `more` is put
  /// before [stop].
  static std::string request_text(const std::string& stop, const std::string& more = {},
                                  const std::string& method = "metropolis_hastings") {
    return "[world]\nname = \"ball_2d\"\n[sampler]\nmethod = \"" + method +
           "\"\nchains = 3\nseed = 17\nround_scans = 20\n" + more + "[stop]\n" + stop +
           "\n[output]\nthin = 3\nkeep_max = 50\n";
  }

  static RunSummary session(const std::string& request_text, const RunOptions& options,
                            std::uint32_t threads = 1) {
    base::PosixFileSystem files;
    return session_on(files, request_text, options, threads);
  }

  static RunSummary session_on(base::FileSystem& files, const std::string& request_text,
                               const RunOptions& options, std::uint32_t threads = 1) {
    const run::Catalogue catalogue;
    auto request = request::read_request(request_text, "request.toml", catalogue.bindings());
    EXPECT_TRUE(request.ok());
    const run::WorldEntry& world = catalogue.world_of(request.value());
    const auto worker = world.make_worker(request.value());
    const auto reader = world.make_reader(request.value());
    const auto plan = run::make_plan(request.value(), world);
    const base::SteadyClock clock;
    const sampling::BlockRunner runner(*worker, clock);
    LocalCrew crew(runner, threads);
    return run_request(
        {.request = request.value(),
         .reader = *reader,
         .plan = *plan,
         .plan_of =
             [&](const request::Cut& cut) { return run::make_plan(request.value(), world, cut); },
         .crew = crew,
         .clock = clock,
         .files = files,
         .results_version = "results of tests"},
        options);
  }

  /// Returns a function that requests a stop at its n-th call.
  static std::function<bool()> stop_at(std::uint64_t question) {
    return [question, asked = std::uint64_t{0}]() mutable { return ++asked >= question; };
  }

  /// Like stop_at(), but requests no stop if the previous session was stopped while it wrote its
  /// archive. Otherwise the run would never end: writing an archive takes more than n calls.
  static std::function<bool()> stop_before_writing(std::uint64_t question,
                                                   const RunSummary& before) {
    return before.is_archive_given_up ? std::function<bool()>() : stop_at(question);
  }
};

}  // namespace sleight::coordinator::testing
