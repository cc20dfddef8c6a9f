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
#include "worker/sampling/stage_search.h"

namespace sleight::sampling {

/// The search gives up after this number of consecutive starts without a find.
inline constexpr std::uint64_t k_starts_in_vain_max = 64;

/// A world's texts for messages about its search.
struct SearchTexts {
  std::vector<std::string> stages{};  ///< Names, such as "ball 3 of 16".
  std::vector<MissKind> misses{};
  std::string advice{};  ///< What to do if the search gives up: a sentence, or empty.
};

class SearchLanes {
 public:
  /// `wanted` is the number of finds to search for.
  SearchLanes(std::uint64_t seed, std::uint64_t wanted, SearchTexts texts = {});

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
  /// What a start without a find reached, as in SearchEffort.
  struct Reached {
    std::uint32_t furthest = 0;
    std::optional<Miss> nearest{};
  };
  struct Lane {
    std::uint64_t handed_out = 0;
    std::vector<bool> found{};       ///< By consumed scan.
    std::vector<Reached> reached{};  ///< By consumed scan.
    std::vector<double> log_ps{};    ///< By consumed scan: log p_w + log p_c.
  };
  using Next = std::pair<std::uint64_t, std::uint32_t>;  ///< (scan, lane).

  void count();
  /// Describes the in_vain_ starts.
  std::string why_in_vain() const;

  std::uint64_t seed_;
  SearchTexts texts_;
  std::vector<Lane> lanes_;
  std::set<Next> idle_;  ///< Lanes with nothing handed out, by their next scans.
  plan::Finds finds_;
  std::vector<plan::Find> found_;  ///< Finds that count.
  std::uint64_t counted_ = 0;      ///< Starts that finds_ covers.
  std::uint64_t in_vain_ = 0;      ///< Counted starts since the last find.
  std::uint64_t starts_ = 0;
  std::uint64_t out_ = 0;          ///< Starts handed out whose results have not arrived.
  std::uint64_t found_ahead_ = 0;  ///< Finds that don't count yet.
};

}  // namespace sleight::sampling
