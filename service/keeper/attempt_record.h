// What a job's folder says of its newest attempt: the file `attempt.json`.
//
// An attempt is the n-th start of a job's program. Its keeper writes the record twice: before it
// starts the program, and when the program and all its descendants are gone. What is in the file
// thus says, together with the keeper's lock, how far an attempt has come, whatever was killed
// (backend.h).
//
// Invariants:
//   1. The file is one whole record at any moment, or is not there: each is written beside it,
//      synced, renamed, and the folder synced.
//   2. Records only go forward: attempts ascend, and an attempt's end follows its beginning and
//      never changes.
//   3. An end finds its place on a full disk: its bytes are written, as zeros, before the program
//      starts (`RecordFile::begin`). On file systems that copy what they overwrite (btrfs, ZFS) it
//      may not.
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
  in_order,  ///< the run stores everything, writes its archive and ends
  now        ///< its processes are killed; what they had committed stays
};

/// A process that no later one is taken for, though its number be used again.
struct ProcessIdentity {
  pid_t pid = 0;
  std::uint64_t start_ticks = 0;  ///< since the machine started, as the kernel says
  std::string boot{};             ///< of which start of the machine

  bool operator==(const ProcessIdentity&) const = default;
};

/// Why the keeper killed the program, if it did.
enum class KilledFor : std::uint8_t {
  nothing,
  asked,         ///< Stop::now
  lingering,     ///< it told its end and did not exit within the grace
  without_ranks  ///< mpirun whose ranks had all gone did not exit within the grace
};

struct AttemptEnd {
  /// One of the three says how the program ended.
  std::optional<int> exit_code{};
  std::optional<int> signal{};
  std::string not_started{};  ///< why it could not be started

  KilledFor killed_for = KilledFor::nothing;
  std::optional<Stop> stop_asked{};  ///< the last that the keeper passed on
  /// How the session ended, from its pipe or its store. None: it died, or never began; then the
  /// three above are all that is known.
  std::optional<events::RunEnd> run_end{};
  double wall_s = 0;                   ///< from the program's start to its end
  double processor_s = 0;              ///< of the program and all its descendants
  std::uint64_t memory_bytes_max = 0;  ///< resident, of the largest of them
  double ended_unix_s = 0;
  std::vector<std::string> log_tail{};  ///< the last k_tail_lines_max lines that it printed

  bool operator==(const AttemptEnd&) const = default;
};

struct AttemptRecord {
  std::uint32_t attempt = 0;  ///< from 1
  ProcessIdentity keeper{};
  std::vector<std::string> command{};  ///< program and arguments; its folder is the job's
  double begun_unix_s = 0;
  std::uint64_t epoch_before = 0;  ///< of the newest session that the run's store had then; 0: none
  std::optional<AttemptEnd> end{};

  bool operator==(const AttemptRecord&) const = default;
};

inline constexpr std::size_t k_tail_lines_max = 50;
/// A record is no longer: the oldest lines of a tail go first, then the middles of long words.
inline constexpr std::size_t k_record_bytes_max = 64U << 10U;
inline constexpr const char* k_record_name = "attempt.json";

/// A JSON object of at most k_record_bytes_max bytes, ended by a newline.
std::string to_text(const AttemptRecord& record);

/// None for anything that to_text did not write.
std::optional<AttemptRecord> record_of(std::string_view text);

/// Its text, of one moment; empty where the folder has none. Throws base::Error where it can't be
/// read.
std::string record_text_in(const std::string& folder);

/// The record of such a text, none of an empty one. Throws base::Error where it is none of ours.
std::optional<AttemptRecord> record_in(const std::string& folder, const std::string& text);

/// Both.
std::optional<AttemptRecord> read_record(const std::string& folder);

/// Writes the two records of one attempt.
class RecordFile {
 public:
  RecordFile(base::FileSystem& files, std::string folder);

  /// Durable when it returns, with room for the end. Throws base::Error; then the record may be
  /// there or not.
  void begin(const AttemptRecord& record);

  /// Durable when it returns. REQUIRES: `record` has an end; begin has returned; once. Throws
  /// base::Error; then the record of the beginning may stand.
  void end(const AttemptRecord& record);

 private:
  void put(const std::string& beside);
  std::string path(const char* name) const { return folder_ + "/" + name; }

  base::FileSystem& files_;
  std::string folder_;
  std::unique_ptr<base::File> room_;  ///< for the end
};

}  // namespace sleight::keeper
