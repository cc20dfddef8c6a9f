// The record of a job's newest attempt: the file `attempt.json` in the job's folder.
//
// An attempt is the n-th start of a job's program. The keeper writes the record before it starts
// the program, and again after the program and all its descendants have ended. So the record and
// the keeper's lock together show the attempt's state, even if any of the processes were killed
// (backend.h).
//
// Invariants:
//   1. The file is either absent or a complete record. Each record is written to a temporary file,
//      synced and renamed, and the folder is synced.
//   2. Records only advance. Attempts ascend, an attempt's end follows its beginning, and an end
//      never changes.
//   3. The end can be written even on a full disk, because `RecordFile::begin` reserves its bytes
//      as zeros before the program starts. Copy-on-write file systems (btrfs, ZFS) don't guarantee
//      this.
//
// Thread safety: values; a RecordFile belongs to one thread.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/file_system.h"
#include "common/events/run_end.h"

namespace sleight::keeper {

/// How an attempt is stopped.
enum class Stop : std::uint8_t {
  in_order,  ///< the run stores everything, writes its archive and exits
  now        ///< its processes are killed; their commits remain
};

/// Identifies a process even after the kernel reuses its process id.
struct ProcessIdentity {
  pid_t pid = 0;
  std::uint64_t start_ticks = 0;  ///< after boot, as the kernel reports
  std::string boot{};             ///< id of the machine's boot

  bool operator==(const ProcessIdentity&) const = default;
};

/// Why the keeper killed the program, if it did.
enum class KilledFor : std::uint8_t {
  nothing,
  asked,         ///< Stop::now
  lingering,     ///< it reported its end but didn't exit within the grace time
  without_ranks  ///< mpirun without living ranks didn't exit within the grace time
};

struct AttemptEnd {
  /// Exactly one of the next three fields describes the program's end.
  std::optional<int> exit_code{};
  std::optional<int> signal{};
  std::string not_started{};  ///< why the program could not be started

  KilledFor killed_for = KilledFor::nothing;
  std::optional<Stop> stop_asked{};  ///< last stop that the keeper passed on
  /// How the session ended, according to its pipe or its store. None: the session died or never
  /// began, so only the three fields above are known.
  std::optional<events::RunEnd> run_end{};
  double wall_s = 0;                   ///< from the program's start to its end
  double processor_s = 0;              ///< of the program and all its descendants
  std::uint64_t memory_bytes_max = 0;  ///< largest resident size of one of these processes
  double ended_unix_s = 0;
  std::vector<std::string> log_tail{};  ///< the last k_tail_lines_max lines of output

  bool operator==(const AttemptEnd&) const = default;
};

struct AttemptRecord {
  std::uint32_t attempt = 0;  ///< from 1
  ProcessIdentity keeper{};
  std::vector<std::string> command{};  ///< program and arguments, run in the job's folder
  double begun_unix_s = 0;
  std::uint64_t epoch_before = 0;  ///< of the run store's newest session at the beginning; 0: none
  std::optional<AttemptEnd> end{};

  bool operator==(const AttemptRecord&) const = default;
};

inline constexpr std::size_t k_tail_lines_max = 50;
/// Maximum size of a record. If a record is larger, the oldest lines of its tail are dropped, then
/// long messages are cut.
inline constexpr std::size_t k_record_bytes_max = 64U << 10U;
inline constexpr const char* k_record_name = "attempt.json";

/// Returns a JSON object of at most k_record_bytes_max bytes, ended by a newline.
std::string to_text(const AttemptRecord& record);

/// Returns none if to_text() didn't write the text.
std::optional<AttemptRecord> record_of(std::string_view text);

/// Reads the record's text atomically. Empty: no record. Throws base::Error if that fails.
std::string record_text_in(const std::string& folder);

/// Parses the text of a folder's record. None: the text is empty. Throws base::Error if the text is
/// invalid.
std::optional<AttemptRecord> record_in(const std::string& folder, const std::string& text);

/// record_text_in, then record_in.
std::optional<AttemptRecord> read_record(const std::string& folder);

class RecordFile {
 public:
  RecordFile(base::FileSystem& files, std::string folder);

  /// On return, the record is durable and has room for its end. After a base::Error, the record may
  /// exist.
  void begin(const AttemptRecord& record);

  /// Durable on return. REQUIRES: `record` has an end, and begin() has returned. Call end() only
  /// once. After a base::Error, the record of the beginning may remain.
  void end(const AttemptRecord& record);

 private:
  void put(const std::string& beside);
  std::string path(const char* name) const { return folder_ + "/" + name; }

  base::FileSystem& files_;
  std::string folder_;
  std::unique_ptr<base::File> room_;  ///< reserved for the end
};

}  // namespace sleight::keeper
