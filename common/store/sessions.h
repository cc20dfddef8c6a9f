// The sessions that a run has had, as its store tells: what a supervisor reads after a process has
// gone, however it went.
//
// Reads through a connection of its own, beside a writer. Thread safety: a pure function of the
// file.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/events/run_end.h"

namespace sleight::store {

struct Session {
  std::uint64_t epoch = 0;
  std::string program_version{};        ///< base::version() of the program
  std::optional<events::RunEnd> end{};  ///< none: it runs, or died
  std::uint64_t scans_before = 0;       ///< of all replicas, that earlier sessions had committed

  bool operator==(const Session&) const = default;
};

/// In order. Throws base::Error where the folder has no store that can be read, or a row was
/// changed.
std::vector<Session> sessions_of(const std::string& folder);

}  // namespace sleight::store
