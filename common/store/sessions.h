// The sessions that a run has had, as its store tells: what a supervisor reads after a process has
// gone, however it went.
//
// Reads through a connection of its own: beside a writer on a local disk, on a network disk only
// when nobody writes (open_to_read). Thread safety: a pure function of the file.
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

/// Whose store it is, and what it was asked for last.
struct StoredRequest {
  std::string identity_text;    ///< as RunIdentity (run_store.h)
  std::string request_text;     ///< of the newest session
  std::string results_version;  ///< under which all of it was made
  std::string program_version;  ///< of the newest session
};

/// Throws base::Error where the folder has no store that can be read, or one of another format.
StoredRequest stored_request_of(const std::string& folder);

/// In order. Throws base::Error where the folder has no store that can be read, or a row was
/// changed.
std::vector<Session> sessions_of(const std::string& folder);

}  // namespace sleight::store
