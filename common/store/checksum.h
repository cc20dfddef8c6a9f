// Checksums of the run store's rows (XXH3, 64 bits). SQLite has none: a flipped bit on the disk
// would become another animation that can't be told from a right one.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/plan/unit.h"
#include "common/store/put_events.h"

namespace sleight::store {

/// What makes one run's checksums differ from another's, so that rows can't move between stores.
std::uint64_t salt_of(std::string_view identity_text);

/// Of a scan's result together with its key, every field included.
std::int64_t checksum_of(std::uint64_t salt, const plan::ReplicaKey& replica, std::uint64_t scan,
                         const plan::ScanRecord& record);

/// Of where a replica goes on.
std::int64_t checksum_of(std::uint64_t salt, const plan::ReplicaKey& replica,
                         std::uint64_t next_scan, base::BytesView state);

/// A session's place.
struct SessionKey {
  std::uint64_t salt = 0;
  std::uint64_t epoch = 0;
};

/// Of a session's row; `end` is its line, or empty.
std::int64_t checksum_of(const SessionKey& session, std::string_view program_version,
                         std::uint64_t scans_before, std::string_view end);

/// Of an event's row.
std::int64_t checksum_of_event(std::uint64_t salt, std::uint64_t number, std::string_view line);

/// Of how far events are told.
std::int64_t checksum_of(std::uint64_t salt, const ToldFrontier& told);

/// Of a remembered motion; the salt is its owner's.
std::int64_t checksum_of_motion(std::uint64_t salt, base::BytesView state, std::int64_t ends,
                                std::uint64_t columns, base::BytesView numbers);

/// Of a text at a place of its own, "job/17/": so that rows can't change places.
std::int64_t checksum_of_text(std::string_view place, std::string_view text);

/// Throws base::Error: what is in the database at `path` was not written by us as it stands.
[[noreturn]] void refuse_damaged(const std::string& path, const std::string& what);

}  // namespace sleight::store
