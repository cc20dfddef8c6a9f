// The run store's speed in scans per second. The time runs from put() until the scans are
// committed, including fsync.
#include <benchmark/benchmark.h>
#include <stdlib.h>
#include <unistd.h>

#include <string>

#include "common/base/check.h"
#include "common/store/run_store.h"
#include "common/store/stored_run.h"
#include "tests/bench/harness.h"
#include "worker/run/chain_worker.h"
#include "worker/worlds/ball_2d/ball_2d.h"

namespace sleight::bench {
namespace {

using worlds::ball_2d::Ball2d;

constexpr std::uint32_t k_chains = 4;
constexpr std::uint32_t k_units = 25;
constexpr std::uint32_t k_scans_per_unit = 1000;

/// A temporary folder on the current folder's disk.
class Folder {
 public:
  Folder() : path_("sleight-bench-store-XXXXXX") { CHECK(mkdtemp(path_.data()) != nullptr); }
  ~Folder() {
    const store::RunLock lock(path_);
    for (const char* name : {"/store.sqlite", "/store.sqlite-wal", "/store.sqlite-shm", "/lock"}) {
      unlink((path_ + name).c_str());
    }
    rmdir(path_.c_str());
  }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

std::vector<plan::UnitResult> results() {
  const run::ChainWorker<Ball2d> worker(Ball2d{worlds::ball_2d::Parameters{}}, {});
  std::vector<plan::UnitResult> all;
  for (std::uint32_t chain = 0; chain < k_chains; ++chain) {
    base::Bytes state;
    for (std::uint32_t unit = 0; unit < k_units; ++unit) {
      all.push_back(worker.run({.replica = {base::ChainId{chain}, {}},
                                .seed = 1,
                                .first_scan = base::ScanIndex{unit * k_scans_per_unit},
                                .scans = k_scans_per_unit,
                                .starts = unit == 0},
                               state));
      state = all.back().state_after;
    }
  }
  return all;
}

std::uint64_t stored_hash(const std::string& folder) {
  ResultHash hash;
  const store::StoredRun run(folder, {.chains = k_chains, .scans = k_units * k_scans_per_unit});
  for (std::uint32_t chain = 0; chain < k_chains; ++chain) {
    run.for_each_draw(base::ChainId{chain}, [&](base::ScanIndex, const plan::ScanRecord& scan) {
      hash.add(scan.log_constraint);
      hash.add(std::uint64_t{scan.accepted[0]});
      hash.add(std::uint64_t{scan.state.size()});
    });
  }
  return hash.value();
}

void commit(benchmark::State& state) {
  const std::vector<plan::UnitResult> all = results();
  const store::RunIdentity identity{.identity_text = "bench",
                                    .request_text = "bench",
                                    .results_version = "bench",
                                    .program_version = "bench",
                                    .chains = k_chains};
  std::uint64_t hash = 0;
  for (auto _ : state) {
    state.PauseTiming();
    const Folder folder;
    std::vector<plan::UnitResult> copies = all;
    state.ResumeTiming();
    store::RunStore run_store(folder.path(), identity);
    for (plan::UnitResult& result : copies)
      run_store.put(std::move(result));
    run_store.flush();
    state.PauseTiming();
    hash = stored_hash(folder.path());
    state.ResumeTiming();
  }
  state.SetItemsProcessed(state.iterations() * k_chains * k_units * k_scans_per_unit);
  verify(state, hash, 0x69ce590e794d0b8cU);
}
// Use wall-clock time, because the writer has its own thread and waits for the disk.
BENCHMARK(commit)->Name("store/commit")->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sleight::bench
