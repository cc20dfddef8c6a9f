// Hands out a search's starts (stage_search.h) as units of work, counts finds, and ends the search.
//
// Starts are numbered (plan::k_search_lanes). A find is counted only when all earlier starts are
// done, so the counted finds don't depend on workers. If the starts in progress would yield the
// missing finds at the success rate so far, no further starts are handed out. Not thread-safe.
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

/// The search gives up after this number of consecutive starts without a find.
inline constexpr std::uint64_t k_starts_in_vain_max = 64;

class SearchLanes {
 public:
  /// `wanted` is the number of finds to search for. Messages use `stage_names`, the world's stages.
  SearchLanes(std::uint64_t seed, std::uint64_t wanted, std::vector<std::string> stage_names = {});

  static bool has(base::ChainId chain) { return plan::is_search_lane(chain); }
  /// Raises the number of wanted finds; a lower number has no effect.
  void want(std::uint64_t finds);
  std::optional<plan::Unit> next_unit(std::uint32_t scans_max);
  void consume(base::ChainId lane, base::ScanIndex first_scan,
               std::span<const plan::ScanRecord> records);
  bool finished() const { return finds_.found >= finds_.wanted || finds_.gave_up; }
  const plan::Finds& finds() const { return finds_; }
  /// Starts that finds() covers: all starts before the first unfinished start.
  std::uint64_t starts_done() const { return counted_; }
  std::vector<plan::Find> finds_between(std::uint64_t first, std::uint64_t end) const;
  /// Starts whose results have arrived.
  std::uint64_t starts() const { return starts_; }

 private:
  struct Lane {
    std::uint64_t handed_out = 0;
    std::vector<bool> found{};              ///< By consumed scan.
    std::vector<std::uint32_t> furthest{};  ///< By scan: most stages, if no find.
    std::vector<double> log_ps{};           ///< By consumed scan: log p_w + log p_c.
  };
  using Next = std::pair<std::uint64_t, std::uint32_t>;  ///< (scan, lane).

  void count();

  std::uint64_t seed_;
  std::vector<std::string> stage_names_;
  std::vector<Lane> lanes_;
  std::set<Next> idle_;  ///< Lanes with nothing handed out, by their next scans.
  plan::Finds finds_;
  std::vector<plan::Find> found_;  ///< Finds that count.
  std::uint64_t counted_ = 0;      ///< Starts that finds_ covers.
  std::uint64_t in_vain_ = 0;      ///< Counted starts since the last find.
  std::uint32_t furthest_ = 0;     ///< Most stages completed in the in_vain_ starts.
  std::uint64_t starts_ = 0;
  std::uint64_t out_ = 0;          ///< Starts handed out whose results have not arrived.
  std::uint64_t found_ahead_ = 0;  ///< Finds that don't count yet.
};

}  // namespace sleight::sampling
