// How a run goes: counts, and one line of them for people.
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

/// How a run stands; counts cover earlier sessions only where they say so.
struct Progress {
  std::uint64_t scans_done = 0;         ///< over all chains, earlier sessions included, committed
  std::uint64_t scans_total = 0;        ///< 0 where the stop rule can't tell
  std::uint64_t session_scans = 0;      ///< consumed in this session
  std::uint64_t session_satisfied = 0;  ///< of these, satisfied
  std::uint64_t session_proposed = 0;
  std::uint64_t session_accepted = 0;
  std::uint64_t session_simulations = 0;
  std::uint64_t solutions = 0;                 ///< independent solutions, earlier sessions included
  std::uint64_t solutions_wanted = 0;          ///< 0 where the stop rule doesn't ask for them
  plan::Finds finds{};                         ///< of a search, earlier sessions included
  double found_s = 0;                          ///< of this session: when the last find so far came
  std::optional<std::uint64_t> round_trips{};  ///< of a ladder's replicas, if there is one
  plan::Odds odds{};              ///< of a natural throw (WorldLayout::log_natural_throw)
  std::uint64_t prior_draws = 0;  ///< from the prior, which are no scans, of the whole run
  std::uint64_t prior_draws_wanted = 0;
  plan::FailureCounts failures{};  ///< of simulations, earlier sessions included
  std::size_t workers = 0;         ///< threads that compute and are heard of
  double elapsed_s = 0;            ///< of this session
};

/// "ball_2d  12,400 of 40,000 scans (31%)  0:04 left  85,200 sims/s  solutions 4  round trips 12
/// satisfied 6,448 (52%)  accepted 41%  2 workers", in one line, what matters most first: a
/// terminal may show its beginning alone.
std::string progress_line(const std::string& name, const Progress& progress);

/// "log P about -39.1 +- 0.4, still rough (41 of 132 islands)"; once the error can be trusted, "log
/// P -39.12 +- 0.21 (100 islands)" with those that tell it. REQUIRES: they are asked for.
std::string odds_in_words(const plan::Odds& odds);

/// 1234567 as "1,234,567".
std::string grouped(std::uint64_t count);

/// Seconds as "0:04", "12:30" or "3:05:00".
std::string clock_time(double seconds);

}  // namespace sleight::events
