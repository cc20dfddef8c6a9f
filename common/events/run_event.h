// The events of a run, for watchers.
//
// Solutions, failures, ends of rounds and ends of sessions are numbered from 1 without gaps. A
// watcher that remembers the last number that it received can request all events that it missed:
// those with higher numbers. Phases, progress and archives have no number, because only the newest
// of each matters.
//
// An event is a line of JSON. The line has a `number` (0: none), a `kind`, and the fields of that
// kind under the names below.
//
// Thread safety: values.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "common/events/progress.h"
#include "common/events/run_end.h"

namespace sleight::events {

/// A phase of work without a count, such as "writing the archive".
struct Phase {
  std::string words;
  bool operator==(const Phase&) const = default;
};

struct Solution {
  std::uint64_t nth = 0;       ///< among those of its kind, from 1
  bool in_proportion = false;  ///< true: independent solution of a chain; false: find of a search
  std::uint32_t chain = 0;     ///< 0 for a find
  std::uint64_t scan = 0;      ///< for a find, the number of its start
  double log_p = 0;            ///< log density of the state times that of the constraint
  bool operator==(const Solution&) const = default;
};

struct Failure {
  std::string simulation;  ///< the failure kind's name (plan/failure.h)
  std::uint32_t chain = 0;
  std::uint32_t replica = 0;
  std::uint64_t scan = 0;
  std::string file;  ///< input for `sleight replay`; empty: none
  bool operator==(const Failure&) const = default;
};

/// A round ended: a round of one ladder, or of all chains together.
struct RoundEnded {
  std::uint32_t chain = 0;
  std::uint64_t round = 0;                     ///< from 1
  std::uint64_t scans = 0;                     ///< of the chain so far
  std::optional<double> swaps{};               ///< mean acceptance, if there are swaps
  std::optional<std::uint64_t> round_trips{};  ///< of the round, if there are replicas
  bool operator==(const RoundEnded&) const = default;
};

struct ArchiveWritten {
  std::string digest;
  std::uint64_t scans = 0;
  std::uint64_t found = 0;
  bool operator==(const ArchiveWritten&) const = default;
};

struct RunEvent {
  std::uint64_t number = 0;
  std::variant<Phase, Progress, Solution, Failure, RoundEnded, ArchiveWritten, RunEnd> what;
};

/// Returns "phase", "progress", "solution", "failure", "round_ended", "archive_written" or "ended".
std::string_view kind_of(const RunEvent& event);

/// Returns the event as a line with its newline.
std::string to_line(const RunEvent& event);

/// Parses a line, with or without its newline. Returns nothing for other text.
std::optional<RunEvent> run_event_of(std::string_view line);

}  // namespace sleight::events
