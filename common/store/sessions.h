// Reads a run's sessions from its store. Works however the last process ended.
//
// Uses a separate connection. On a local disk a writer may be active. On a network disk, nobody may
// write (open_to_read). Thread safety: pure functions of the file.
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
  std::optional<events::RunEnd> end{};  ///< empty: running or died
  std::uint64_t scans_before = 0;       ///< scans of all replicas committed by earlier sessions

  bool operator==(const Session&) const = default;
};

/// The request whose run is in the store, and the version of the newest session.
struct StoredRequest {
  std::string identity_text;    ///< as in RunIdentity (run_store.h)
  std::string request_text;     ///< of the newest session
  std::string results_version;  ///< of all results in the store
  std::string program_version;  ///< of the newest session
};

/// Throws base::Error if the folder has no readable store, or a store of another format.
StoredRequest stored_request_of(const std::string& folder);

/// Returns the sessions in order. Throws base::Error if the folder has no readable store or a row
/// was changed.
std::vector<Session> sessions_of(const std::string& folder);

}  // namespace sleight::store
