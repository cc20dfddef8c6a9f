#include "tests/tempering/tempering_loop.h"

#include <utility>

#include "common/math/elementary.h"
#include "common/random/stream.h"

namespace sleight::sampling {
namespace {

/// Each level's replica makes a scan at the level's temperature.
std::vector<plan::ScanRecord> explore(RoundReport& round, std::span<const std::uint32_t> at,
                                      std::uint64_t scan, const MakeScan& make_scan) {
  std::vector<plan::ScanRecord> made;
  std::vector<LevelScan> levels;
  for (std::size_t level = 0; level < at.size(); ++level) {
    made.push_back(make_scan({at[level], scan, round.ladder()[level], round.scales[level]}));
    levels.push_back({made.back().log_constraint, made.back().satisfied});
    round.counts[level].add(made.back().proposed, made.back().accepted);
  }
  round.statistics.add(levels);
  return made;
}

/// If i + scan is even, the pair (i, i + 1) swaps temperatures with probability min(1, ratio). The
/// number of the hotter level selects the pair's random numbers. For other purposes, a replica's
/// number selects random numbers.
void communicate(const LadderOptions& options, std::span<const double> ladder, std::uint64_t scan,
                 std::span<const plan::ScanRecord> made, std::span<std::uint32_t> at) {
  for (std::uint32_t i = scan % 2; i + 1 < at.size(); i += 2) {
    const double hotter_l = made[i].log_constraint;
    const double cooler_l = made[i + 1].log_constraint;
    const double log_ratio =
        hotter_l == cooler_l ? 0 : (ladder[i + 1] - ladder[i]) * (hotter_l - cooler_l);
    random::Stream stream({.seed = options.seed,
                           .chain = options.chain,
                           .replica = base::ReplicaId{i},
                           .purpose = random::Purpose::swap},
                          scan);
    if (math::log(stream.uniform()) < log_ratio) std::swap(at[i], at[i + 1]);
  }
}

}  // namespace

std::vector<RoundReport> tempering_loop(const LadderOptions& options, std::uint64_t scans,
                                        const MakeScan& make_scan) {
  std::vector<RoundReport> rounds{first_round(options)};
  std::vector<std::uint32_t> at;  // Replica by level, hottest first.
  std::uint32_t born = 0;
  while (born < options.first_ladder.size())
    at.push_back(born++);

  for (std::uint64_t scan = 0; scan < scans; ++scan) {
    // If the options request simulated annealing, it brings each replica to its first temperature.
    if (scan < options.anneal_scans) {
      const double share = static_cast<double>(scan) / static_cast<double>(options.anneal_scans);
      for (const std::uint32_t replica : at)
        make_scan({replica, scan, options.first_ladder[replica] * share, {}});
      continue;
    }

    // All levels make the scan. Then neighbouring levels may swap.
    const std::vector<plan::ScanRecord> made = explore(rounds.back(), at, scan, make_scan);
    communicate(options, rounds.back().ladder(), scan, made, at);

    // At a round's end, make a new ladder. The coolest replicas stay, and new replicas are the
    // hottest.
    if (scan + 1 < rounds.back().end_scan()) continue;
    rounds.push_back(next_round(options, rounds.back()));
    const std::size_t levels = rounds.back().ladder().size();
    if (at.size() > levels) at.erase(at.begin(), at.end() - static_cast<std::ptrdiff_t>(levels));
    for (std::size_t hottest = 0; at.size() < levels; ++hottest)
      at.insert(at.begin() + static_cast<std::ptrdiff_t>(hottest), born++);
  }
  return rounds;
}

}  // namespace sleight::sampling
