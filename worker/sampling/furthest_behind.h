// Selects the chain that runs next: the chain with the fewest scans. So all chains reach a common
// waiting point together. If a chain had no work, it is not queried again until it moves or the
// query changes. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>

namespace sleight::sampling {

class FurthestBehind {
 public:
  /// A chain's work depends on these conditions and on the chain's own results.
  struct Asked {
    std::uint64_t horizon = 0;  ///< Scans below this number may begin.
    bool splits = false;        ///< Whether a chain with work in progress may hand out more.
    friend bool operator==(const Asked&, const Asked&) = default;
  };

  /// Chains without scans. REQUIRES: at least one chain.
  explicit FurthestBehind(std::size_t chains);

  /// Number of scans that every chain has completed.
  std::uint64_t least() const { return by_scans_.begin()->first; }
  /// Sum of min(scans, end) over all chains.
  std::uint64_t sum(std::uint64_t end) const;
  /// Number of chains with fewer scans than `horizon`.
  std::size_t going(std::uint64_t horizon);

  /// Reports that a chain now has `scans` scans. REQUIRES: no fewer than before.
  void moved(std::size_t chain, std::uint64_t scans);

  /// Calls `next` for chains in order of (scans, chain), and returns the first non-empty result.
  /// REQUIRES: if `next` returns nothing for a chain, either the chain has work in progress, or
  /// only a change of `asked` gives it work.
  template <class Next>
  auto first(const Asked& asked, const Next& next) -> decltype(next(std::size_t{0})) {
    if (asked != asked_) {
      asked_ = asked;
      may_give_ = by_scans_;
    }
    while (!may_give_.empty()) {
      if (auto found = next(may_give_.begin()->second)) return found;
      may_give_.erase(may_give_.begin());
    }
    return {};
  }

 private:
  using Order = std::set<std::pair<std::uint64_t, std::size_t>>;  ///< (scans, chain).

  std::vector<std::uint64_t> scans_;
  Order by_scans_;
  Order may_give_;  ///< Chains of by_scans_ for which `next` has not returned nothing.
  Asked asked_;
  std::uint64_t horizon_ = 0;  ///< The horizon for which going_ was computed.
  std::size_t going_ = 0;
};

}  // namespace sleight::sampling
