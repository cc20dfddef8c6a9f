// Counts failing simulations: first among draws from a request's prior, then among candidates of
// plain chains at inverse temperature 1. Writes each failure as a file that `sleight replay`
// repeats.
//
// Example: `sleight-failure-rates requests/hi.toml --simulations 1000000 --keep failures`.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "common/base/check.h"
#include "common/base/file_system.h"
#include "common/base/version.h"
#include "common/failure_file/failure_file.h"
#include "common/request/document.h"
#include "worker/run/catalogue.h"

namespace sleight {
namespace {

/// Number of scans that a chain runs between two checks of the number of simulations.
constexpr std::uint32_t k_scans = 200;

struct Tally {
  std::uint64_t simulations = 0;
  std::uint64_t overlapping_starts = 0;
  plan::FailureCounts failures;
};

struct Job {
  const plan::UnitWorker& worker;
  std::uint64_t seed = 1;
  double inverse_temperature = 1;
  std::uint64_t simulations = 0;  ///< least number, per chain
  std::string request_text;
  std::string folder;  ///< folder for failures; empty: failures aren't kept
};

void keep(const Job& job, const plan::UnitResult& result) {
  if (job.folder.empty()) return;
  std::size_t nth = 0;
  std::uint64_t scan = 0;
  for (const plan::FailedSimulation& failed : result.failed) {
    nth = failed.scan.value == scan ? nth + 1 : 0;
    scan = failed.scan.value;
    const auto name = failure_file::name_of(result.unit.replica, failed.scan, nth);
    std::ofstream(job.folder + "/" + name)
        << failure_file::to_text({.program_version = std::string(base::version()),
                                  .request_text = job.request_text,
                                  .replica = result.unit.replica,
                                  .failed = failed});
  }
}

Tally run_chain(const Job& job, std::uint32_t chain) {
  Tally tally;
  base::Bytes state;
  // Each temperature has its own replica number, so that file names differ.
  const base::ReplicaId replica{job.inverse_temperature == 0 ? 0U : 1U};
  for (std::uint64_t scan = 0; tally.simulations < job.simulations; scan += k_scans) {
    plan::UnitResult result = job.worker.run({.replica = {base::ChainId{chain}, replica},
                                              .seed = job.seed,
                                              .first_scan = base::ScanIndex{scan},
                                              .scans = k_scans,
                                              .starts = scan == 0,
                                              .inverse_temperatures = {job.inverse_temperature}},
                                             state);
    tally.simulations += result.simulations;
    for (const plan::ScanRecord& record : result.scans) {
      tally.overlapping_starts += record.overlapping_starts;
      tally.failures.add(record.failures);
    }
    keep(job, result);
    state = std::move(result.state_after);
  }
  return tally;
}

Tally run_chains(const Job& job, std::uint32_t chains, std::uint32_t threads) {
  std::mutex mutex;
  Tally all;
  std::uint32_t next = 0;
  const auto work = [&] {
    while (true) {
      std::uint32_t chain = 0;
      {
        const std::lock_guard lock(mutex);
        if (next == chains) return;
        chain = next++;
      }
      const Tally tally = run_chain(job, chain);
      const std::lock_guard lock(mutex);
      all.simulations += tally.simulations;
      all.overlapping_starts += tally.overlapping_starts;
      all.failures.add(tally.failures);
    }
  };
  std::vector<std::thread> running;
  for (std::uint32_t i = 0; i < threads; ++i)
    running.emplace_back(work);
  for (std::thread& thread : running)
    thread.join();
  return all;
}

int main_of(int argc, char** argv) {
  CLI::App app{"Counts simulations that fail, of a request's prior and of chains"};
  std::string path;
  std::uint64_t simulations = 1'000'000;
  std::uint32_t chains = 20;
  std::uint32_t threads = 2;
  std::string folder;
  app.add_option("request", path)->required()->type_name("REQUEST.toml");
  app.add_option("--simulations", simulations, "Of each of the two")->capture_default_str();
  app.add_option("--chains", chains)->check(CLI::Range(1, 4000))->capture_default_str();
  app.add_option("--threads", threads)->check(CLI::Range(1, 256))->capture_default_str();
  app.add_option("--keep", folder, "A folder for failures")->type_name("DIR");
  CLI11_PARSE(app, argc, argv);
  if (!folder.empty()) std::filesystem::create_directories(folder);

  const run::Catalogue catalogue;
  const auto read = request::read_request(base::read_text_file(path, request::k_request_bytes_max),
                                          path, catalogue.bindings());
  if (!read) {
    fmt::print(stderr, "{}\n", request::to_string(read.error().front()));
    return 3;
  }
  const request::DirectionRequest& request = read.value();
  fmt::print("{}, seed {}, sleight {}\n", path, request.sampler.seed, base::version());
  for (const double beta : {0.0, 1.0}) {
    const auto worker = catalogue.world_of(request).make_worker(request);
    const Tally tally = run_chains({.worker = *worker,
                                    .seed = request.sampler.seed,
                                    .inverse_temperature = beta,
                                    .simulations = (simulations + chains - 1) / chains,
                                    .request_text = request::normalised_text(request),
                                    .folder = folder},
                                   chains, threads);
    fmt::print("  {}: {} simulations, {} starts overlap, {} failed{}{}\n",
               beta == 0 ? "draws from the prior" : "chains at inverse temperature 1",
               tally.simulations, tally.overlapping_starts, tally.failures.total(),
               tally.failures.total() > 0 ? ": " : "", plan::to_string(tally.failures));
  }
  return 0;
}

}  // namespace
}  // namespace sleight

int main(int argc, char** argv) {
  return sleight::main_of(argc, argv);
}
