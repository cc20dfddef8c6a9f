#include "worker/sampling/solutions.h"

#include <algorithm>
#include <tuple>

namespace sleight::sampling {

void Solutions::add(std::uint64_t scan, const plan::ScanRecord& record) {
  if (!record.satisfied || record.inverse_temperature != 1) return;
  const auto known = std::ranges::lower_bound(lineages_, record.lineage);
  if (known != lineages_.end() && *known == record.lineage) return;
  lineages_.insert(known, record.lineage);
  const auto place = [](const First& one) { return std::tuple(one.scan, one.lineage); };
  firsts_.insert(
      std::ranges::upper_bound(firsts_, std::tuple(scan, record.lineage), {}, place),
      {.scan = scan, .lineage = record.lineage, .log_p = record.log_prior + record.log_constraint});
}

std::uint64_t Solutions::before(std::uint64_t scan) const {
  return between(0, scan).size();
}

std::span<const Solutions::First> Solutions::between(std::uint64_t first, std::uint64_t end) const {
  const auto begin = std::ranges::lower_bound(firsts_, first, {}, &First::scan);
  return {begin, std::ranges::lower_bound(begin, firsts_.end(), end, {}, &First::scan)};
}

std::vector<plan::Solution> solutions_between(std::span<const Solutions* const> chains,
                                              std::uint64_t after, std::uint64_t until) {
  std::vector<plan::Solution> all;
  for (std::uint32_t id = 0; id < chains.size(); ++id) {
    if (chains[id] == nullptr) continue;
    for (const Solutions::First& first : chains[id]->between(after, until))
      all.push_back({.chain = base::ChainId{id},
                     .scan = first.scan,
                     .log_p = first.log_p,
                     .decided = first.scan + 1});
  }
  // One chain's solutions are already in order.
  std::ranges::stable_sort(all, {}, &plan::Solution::decided);
  return all;
}

}  // namespace sleight::sampling
