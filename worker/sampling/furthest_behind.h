// The chain that runs next: the one that is furthest behind, so that all arrive together at a point
// that waits for all. Chains are known by their numbers.
//
// A chain that had nothing to give is not asked again before it moves or the horizon changes: of a
// thousand chains that are all at work, none is asked in vain.
// Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>

namespace sleight::sampling {

class FurthestBehind {
 public:
  /// What a chain's answer hangs on besides its own results.
  struct Asked {
    std::uint64_t horizon = 0;  ///< scans that may be begun
    bool splits = false;        ///< whether a chain that is at work may give more
    friend bool operator==(const Asked&, const Asked&) = default;
  };

  /// Chains without a scan. REQUIRES: one at least.
  explicit FurthestBehind(std::size_t chains);

  /// Scans that all have.
  std::uint64_t least() const { return by_scans_.begin()->first; }
  /// Scans over all chains, of each at most so many.
  std::uint64_t sum(std::uint64_t end) const;
  /// Chains with fewer scans than this.
  std::size_t going(std::uint64_t horizon);

  /// A chain has consumed results and now has so many scans, no fewer than before.
  void moved(std::size_t chain, std::uint64_t scans);

  /// What `next` has of the chain with the fewest scans, the lowest number among equals; where that
  /// is nothing, of the next one, and so on. REQUIRES: a chain without anything has something out
  /// whose coming back moves it, or comes to have some for another question only.
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
  using Order = std::set<std::pair<std::uint64_t, std::size_t>>;  ///< (scans, chain)

  std::vector<std::uint64_t> scans_;
  Order by_scans_;
  Order may_give_;  ///< those of by_scans_ that have not answered with nothing
  Asked asked_;
  std::uint64_t horizon_ = 0;  ///< that going_ is of
  std::size_t going_ = 0;
};

}  // namespace sleight::sampling
