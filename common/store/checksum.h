// Checksums of the run store's rows (XXH3, 64 bits). SQLite has no checksums, so a flipped bit on
// the disk would change an animation without any error.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/plan/unit.h"
#include "common/store/put_events.h"

namespace sleight::store {

/// Returns the salt of one run's checksums. Because of the salt, a row from another store is
/// detected.
std::uint64_t salt_of(std::string_view identity_text);

/// Covers a scan's key and every field of its result.
std::int64_t checksum_of(std::uint64_t salt, const plan::ReplicaKey& replica, std::uint64_t scan,
                         const plan::ScanRecord& record);

/// Covers a replica's progress: its next scan and its state.
std::int64_t checksum_of(std::uint64_t salt, const plan::ReplicaKey& replica,
                         std::uint64_t next_scan, base::BytesView state);

struct SessionKey {
  std::uint64_t salt = 0;
  std::uint64_t epoch = 0;
};

/// Covers a session's row. `end`: JSON line of the session's end; empty: no end is recorded.
std::int64_t checksum_of(const SessionKey& session, std::string_view program_version,
                         std::uint64_t scans_before, std::string_view end);

/// Covers an event's row.
std::int64_t checksum_of_event(std::uint64_t salt, std::uint64_t number, std::string_view line);

/// Covers the progress of event numbering.
std::int64_t checksum_of(std::uint64_t salt, const ToldFrontier& told);

/// Covers a cached motion. `salt` belongs to the motion's request and program version.
std::int64_t checksum_of_motion(std::uint64_t salt, base::BytesView state, std::int64_t ends,
                                std::uint64_t columns, base::BytesView numbers);

/// Covers a text and its place, such as "job/17/". So the checksum of a text at a wrong place is
/// wrong.
std::int64_t checksum_of_text(std::string_view place, std::string_view text);

/// Throws a base::Error whose message says that the database at `path` was changed or damaged.
[[noreturn]] void refuse_damaged(const std::string& path, const std::string& what);

}  // namespace sleight::store
