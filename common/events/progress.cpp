#include "common/events/progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace sleight::events {
namespace {

/// Maximum displayed time. A slow start can lead to estimates that would overflow an integer.
constexpr double k_seconds_max = 1e12;

double percent(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0 : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

std::string grouped(std::uint64_t count) {
  const std::string digits = std::to_string(count);
  std::string text;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) text += ',';
    text += digits[i];
  }
  return text;
}

std::string clock_time(double seconds) {
  const double bounded = std::min(std::max(0.0, std::ceil(seconds)), k_seconds_max);
  const auto whole = static_cast<std::uint64_t>(bounded);
  const std::uint64_t hours = whole / 3600;
  const std::uint64_t minutes = whole / 60 % 60;
  if (hours > 0) return fmt::format("{}:{:02}:{:02}", hours, minutes, whole % 60);
  return fmt::format("{}:{:02}", minutes, whole % 60);
}

namespace {

/// Returns this session's finds, such as "5 found after 0.2 s".
std::string finds_in_words(const Progress& progress) {
  const plan::Finds& finds = progress.finds;
  const bool all = finds.found >= finds.wanted && finds.found > 0;
  const std::string of = all ? "" : fmt::format(" of {}", grouped(finds.wanted));
  return fmt::format("{}{} found after {:.1f} s{}", grouped(finds.found), of, progress.found_s,
                     finds.gave_up ? ", the search gave up" : "");
}

double per_second(std::uint64_t count, const Progress& progress) {
  return progress.elapsed_s > 0 ? static_cast<double>(count) / progress.elapsed_s : 0;
}

/// Returns text such as "1,200 of 4,000 scans (30%)  0:12 left" or "1,200 scans".
std::string scans_in_words(const Progress& progress) {
  if (progress.scans_total == 0) return fmt::format("{} scans", grouped(progress.scans_done));
  std::string words = fmt::format("{} of {} scans ({:.0f}%)", grouped(progress.scans_done),
                                  grouped(progress.scans_total),
                                  std::floor(percent(progress.scans_done, progress.scans_total)));
  const double rate = per_second(progress.session_scans, progress);
  if (progress.scans_total > progress.scans_done && rate > 0) {
    const auto left = static_cast<double>(progress.scans_total - progress.scans_done);
    words += fmt::format("  {} left", clock_time(left / rate));
  }
  return words;
}

/// Returns text such as "85,200 sims/s". If prior draws are missing, adds how many there are.
std::string effort_in_words(const Progress& progress) {
  const double rate = per_second(progress.session_simulations, progress);
  std::string words = fmt::format("{} sims/s", grouped(static_cast<std::uint64_t>(rate)));
  if (progress.prior_draws < progress.prior_draws_wanted) {
    words += fmt::format("  {} of {} prior draws", grouped(progress.prior_draws),
                         grouped(progress.prior_draws_wanted));
  }
  return words;
}

/// Returns a summary line with the number of islands and the time left. An island is a scan.
std::string odds_line(const std::string& name, const Progress& progress) {
  std::string line = fmt::format("{}  ", name);
  if (progress.finds.wanted > 0) line += finds_in_words(progress) + "  ";
  line += odds_in_words(progress.odds);
  const double rate = per_second(progress.session_scans, progress);
  if (progress.scans_total > progress.scans_done && rate > 0) {
    const auto left = static_cast<double>(progress.scans_total - progress.scans_done);
    line += fmt::format("  {} left", clock_time(left / rate));
  }
  if (progress.failures.total() > 0)
    line += fmt::format("  {} FAILED", grouped(progress.failures.total()));
  return fmt::format("{}  {}  {} worker{}", line, effort_in_words(progress), progress.workers,
                     progress.workers == 1 ? "" : "s");
}

std::string search_line(const std::string& name, const Progress& progress) {
  std::string line = fmt::format("{}  {}", name, finds_in_words(progress));
  const plan::Finds& finds = progress.finds;
  if (finds.relaxed_wanted > 0) {
    line += fmt::format("  {} of {} relaxed  {}", grouped(finds.relaxed),
                        grouped(finds.relaxed_wanted), scans_in_words(progress));
  }
  // A start's simulations are counted when the start ends. A start may take a long time.
  line += progress.session_simulations == 0
              ? fmt::format("  first starts running for {}", clock_time(progress.elapsed_s))
              : fmt::format("  {} simulations  {}", grouped(progress.session_simulations),
                            effort_in_words(progress));
  return fmt::format("{}  {} worker{}", line, progress.workers, progress.workers == 1 ? "" : "s");
}

}  // namespace

std::string odds_in_words(const plan::Odds& odds) {
  const std::string islands = fmt::format("{}{} island{}", grouped(odds.islands),
                                          odds.wanted > odds.islands && !odds.is_final
                                              ? fmt::format(" of {}", grouped(odds.wanted))
                                              : "",
                                          odds.islands == 1 && odds.wanted <= 1 ? "" : "s");
  if (!odds.log_p) return fmt::format("log P not known yet ({})", islands);
  const std::string error =
      odds.log_error ? fmt::format(" +- {:.{}f}", *odds.log_error, odds.is_final ? 2 : 1) : "";
  if (odds.is_final) return fmt::format("log P {:.2f}{} ({})", *odds.log_p, error, islands);
  return fmt::format("log P about {:.1f}{}, still rough ({})", *odds.log_p, error, islands);
}

std::string progress_line(const std::string& name, const Progress& progress) {
  if (progress.odds.are_asked) return odds_line(name, progress);
  if (progress.finds.is_all) return search_line(name, progress);
  std::string line = name;
  if (progress.finds.wanted > 0) line += "  " + finds_in_words(progress);
  line += "  " + scans_in_words(progress);
  if (progress.failures.total() > 0)
    line += fmt::format("  {} FAILED", grouped(progress.failures.total()));
  line += "  " + effort_in_words(progress);
  const bool has_finds = progress.finds.wanted > 0;
  std::string solutions = grouped(progress.solutions);
  if (progress.solutions_wanted > 0)
    solutions += fmt::format(" of {}", grouped(progress.solutions_wanted));
  line += has_finds ? fmt::format("  {} in proportion", solutions) : "  solutions " + solutions;
  if (progress.round_trips) {
    line += fmt::format("  round trips {}", grouped(*progress.round_trips));
  }
  line += fmt::format("  satisfied {} ({:.0f}%)", grouped(progress.session_satisfied),
                      percent(progress.session_satisfied, progress.session_scans));
  line += fmt::format("  accepted {:.0f}%",
                      percent(progress.session_accepted, progress.session_proposed));
  line += fmt::format("  {} worker{}", progress.workers, progress.workers == 1 ? "" : "s");
  return line;
}

}  // namespace sleight::events
