// A run's progress: counts, and a summary line for people.
//
// Thread safety: values and pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "common/plan/failure.h"
#include "common/plan/plan.h"

namespace sleight::events {

/// Counts cover only this session unless stated otherwise.
struct Progress {
  std::uint64_t scans_done = 0;         ///< committed, of all chains and sessions
  std::uint64_t scans_total = 0;        ///< 0: unknown from the stop rule
  std::uint64_t session_scans = 0;      ///< consumed in this session
  std::uint64_t session_satisfied = 0;  ///< of session_scans, those that satisfied
  std::uint64_t session_proposed = 0;
  std::uint64_t session_accepted = 0;
  std::uint64_t session_simulations = 0;
  std::uint64_t solutions = 0;                 ///< independent solutions of all sessions
  std::uint64_t solutions_wanted = 0;          ///< 0: not in the stop rule
  plan::Finds finds{};                         ///< of a search, all sessions
  double found_s = 0;                          ///< time of the last find in this session
  std::optional<std::uint64_t> round_trips{};  ///< of a ladder's replicas, if any
  plan::Odds odds{};              ///< of a natural throw (WorldLayout::log_natural_throw)
  std::uint64_t prior_draws = 0;  ///< draws from the prior, which are not scans, of all sessions
  std::uint64_t prior_draws_wanted = 0;
  plan::FailureCounts failures{};  ///< failed simulations, all sessions
  std::size_t workers = 0;         ///< computing threads that report
  double elapsed_s = 0;            ///< of this session
};

/// Returns one line. The most important parts come first, because a terminal may truncate the line.
/// Example (one line):
/// "ball_2d  12,400 of 40,000 scans (31%)  0:04 left  85,200 sims/s  solutions 4  round trips 12
/// satisfied 6,448 (52%)  accepted 41%  2 workers".
std::string progress_line(const std::string& name, const Progress& progress);

/// Returns text such as "log P about -39.1 +- 0.4, still rough (41 of 132 islands)". If the error
/// is reliable, returns text such as "log P -39.12 +- 0.21 (100 islands)". REQUIRES: the run
/// requests odds.
std::string odds_in_words(const plan::Odds& odds);

/// Formats 1234567 as "1,234,567".
std::string grouped(std::uint64_t count);

/// Formats seconds as "0:04", "12:30" or "3:05:00".
std::string clock_time(double seconds);

}  // namespace sleight::events
