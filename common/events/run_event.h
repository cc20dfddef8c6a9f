// What happens in a run, for people and services that watch it.
//
// Solutions, failures, ends of rounds and ends of sessions are numbered from 1 without a gap; a
// watcher that knows the number of the last one it saw has missed what comes after it, and nothing
// else. Phases, progress and archives are not numbered: only the newest of each is of use.
//
// An event is a line of JSON: its `number` (0: none), its `kind`, and what belongs to the kind by
// the names of the fields below.
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

/// What goes on where there is nothing to count: "writing the archive".
struct Phase {
  std::string words;
  bool operator==(const Phase&) const = default;
};

struct Solution {
  std::uint64_t nth = 0;       ///< of its sort, from 1
  bool in_proportion = false;  ///< an independent solution of a chain; else a find of a search
  std::uint32_t chain = 0;     ///< 0 of a find
  std::uint64_t scan = 0;      ///< of a find the number of its start
  double log_p = 0;            ///< log density of the state times the constraint's
  bool operator==(const Solution&) const = default;
};

struct Failure {
  std::string simulation;  ///< the kind's name (plan/failure.h)
  std::uint32_t chain = 0;
  std::uint32_t replica = 0;
  std::uint64_t scan = 0;
  std::string file;  ///< that `sleight replay` repeats; empty: none was kept
  bool operator==(const Failure&) const = default;
};

/// Of one ladder, or of all chains together.
struct RoundEnded {
  std::uint32_t chain = 0;
  std::uint64_t round = 0;                     ///< from 1
  std::uint64_t scans = 0;                     ///< that the chain has by then
  std::optional<double> swaps{};               ///< mean acceptance, where there are any
  std::optional<std::uint64_t> round_trips{};  ///< of the round, likewise
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

/// "phase", "progress", "solution", "failure", "round_ended", "archive_written", "ended".
std::string_view kind_of(const RunEvent& event);

/// The event as a line, its newline included.
std::string to_line(const RunEvent& event);

/// None for anything that is no such line, with or without its newline.
std::optional<RunEvent> run_event_of(std::string_view line);

}  // namespace sleight::events
