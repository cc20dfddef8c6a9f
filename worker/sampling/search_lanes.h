// The starts of a search (stage_search.h) as units of work: which come next, what they found, and
// when it is enough.
//
// Starts are numbered (plan::k_search_lanes). A find counts when all starts before its own are
// done: so the first so many finds are the same ones whoever makes them.
// As many starts are out at a time as give the missing finds, if they find something as often as
// those before them.
// Not thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/plan/plan.h"
#include "common/plan/unit.h"

namespace sleight::sampling {

/// So many starts in a row without a find, and the search gives up.
inline constexpr std::uint64_t k_starts_in_vain_max = 64;

class SearchLanes {
 public:
  /// `wanted` finds; 0: nothing is searched for. `stage_names`: of the world, for people.
  SearchLanes(std::uint64_t seed, std::uint64_t wanted, std::vector<std::string> stage_names = {});

  static bool has(base::ChainId chain) { return plan::is_search_lane(chain); }
  /// More finds are wanted than before; of fewer nothing comes.
  void want(std::uint64_t finds);
  /// As Plan's.
  std::optional<plan::Unit> next_unit(std::uint32_t scans_max);
  void consume(base::ChainId lane, base::ScanIndex first_scan,
               std::span<const plan::ScanRecord> records);
  bool finished() const { return finds_.found >= finds_.wanted || finds_.gave_up; }
  const plan::Finds& finds() const { return finds_; }
  /// Starts that finds() tells of: all before the first one that is not done.
  std::uint64_t starts_done() const { return counted_; }
  /// As Plan's.
  std::vector<plan::Find> finds_between(std::uint64_t first, std::uint64_t end) const;
  /// Starts whose results came.
  std::uint64_t starts() const { return starts_; }

 private:
  struct Lane {
    std::uint64_t handed_out = 0;
    std::vector<bool> found{};              ///< by scan consumed
    std::vector<std::uint32_t> furthest{};  ///< likewise: stages that stood, of those in vain
    std::vector<double> log_ps{};           ///< likewise: log p_w + log p_c
  };
  using Next = std::pair<std::uint64_t, std::uint32_t>;  ///< (scan, lane)

  /// Goes on over the starts that are done, to the first that isn't.
  void count();

  std::uint64_t seed_;
  std::vector<std::string> stage_names_;
  std::vector<Lane> lanes_;
  std::set<Next> idle_;  ///< lanes with nothing out, by their next scans
  plan::Finds finds_;
  std::vector<plan::Find> found_;  ///< those that count
  std::uint64_t counted_ = 0;      ///< starts, of which finds_ tells
  std::uint64_t in_vain_ = 0;      ///< of these, the last ones without a find
  std::uint32_t furthest_ = 0;     ///< stages that stood in these at most
  std::uint64_t starts_ = 0;
  std::uint64_t out_ = 0;          ///< starts handed out whose results have not come
  std::uint64_t found_ahead_ = 0;  ///< finds that do not count yet
};

}  // namespace sleight::sampling
