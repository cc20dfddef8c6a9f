#include "common/store/told_events.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <limits>
#include <memory>
#include <string_view>
#include <utility>

#include "common/base/check.h"
#include "common/base/error.h"
#include "common/events/event_log.h"
#include "common/store/checksum.h"
#include "common/store/database.h"
#include "common/store/run_store.h"
#include "common/store/scan_rows.h"
#include "common/store/shared_database.h"

namespace sleight::store {
namespace {

constexpr std::uint64_t k_no_end = std::numeric_limits<std::uint64_t>::max();
/// Maximum attempts to read both log files. An attempt fails if the writer rotates the log.
constexpr int k_looks_max = 100;
/// Number of bytes that are read from a file at once. A line is much shorter.
constexpr std::uint64_t k_told_piece_bytes = 256U << 10U;

/// Returns a connection to the store. Null: the run's tables don't exist yet. All tables are
/// created at once.
std::shared_ptr<SharedDatabase> open_store(const std::string& folder) {
  if (::access(RunStore::database_path(folder).c_str(), F_OK) != 0) return nullptr;
  std::shared_ptr<SharedDatabase> database = open_to_read(folder);
  {
    const SharedDatabase::Turn turn = database->turn();
    const bool has_tables =
        turn->prepare("SELECT 1 FROM sqlite_master WHERE type='table' AND name='run'").step();
    if (!has_tables) return nullptr;
  }
  if (const std::string format = run_value(*database, "format_version");
      format != std::to_string(k_store_format)) {
    throw base::Error(
        base::ExitCode::conflict,
        fmt::format("{}: the run store has format {}, but this program reads format {}",
                    database->path(), format, k_store_format));
  }
  return database;
}

}  // namespace

class ToldEvents::LogFile {
 public:
  explicit LogFile(const std::string& path)
      : descriptor_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW)) {
    struct stat status {};
    if (descriptor_ < 0 || ::fstat(descriptor_, &status) != 0) return;
    device_ = status.st_dev;
    inode_ = status.st_ino;
    bytes_ = static_cast<std::uint64_t>(status.st_size);
  }
  ~LogFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  LogFile(const LogFile&) = delete;
  LogFile& operator=(const LogFile&) = delete;

  bool is_there() const { return inode_ != 0; }
  std::uint64_t device() const { return device_; }
  std::uint64_t inode() const { return inode_; }
  bool is(std::uint64_t device, std::uint64_t inode) const {
    return is_there() && device == device_ && inode == inode_;
  }
  /// Returns whether this is the given file and `offset` follows a line in it. `offset` is checked
  /// too, because a new file may reuse a deleted file's inode.
  bool has(std::uint64_t device, std::uint64_t inode, std::uint64_t offset) const {
    if (!is(device, inode) || offset > bytes_) return false;
    char before = '\n';
    return offset == 0 || (::pread(descriptor_, &before, 1, static_cast<off_t>(offset - 1)) == 1 &&
                           before == '\n');
  }
  /// Returns a piece of the file from `offset` on. The piece ends at the latest where the file
  /// ended when it was opened.
  std::string piece_from(std::uint64_t offset) const {
    std::string text;
    if (!is_there() || offset >= bytes_) return text;
    text.resize(std::min(bytes_ - offset, k_told_piece_bytes));
    std::size_t have = 0;
    while (have < text.size()) {
      const ssize_t size = ::pread(descriptor_, text.data() + have, text.size() - have,
                                   static_cast<off_t>(offset + have));
      if (size < 0 && errno == EINTR) continue;
      if (size <= 0) break;
      have += static_cast<std::size_t>(size);
    }
    text.resize(have);
    return text;
  }

 private:
  int descriptor_;
  std::uint64_t device_ = 0;
  std::uint64_t inode_ = 0;
  std::uint64_t bytes_ = 0;
};

struct ToldEvents::Answer {
  std::size_t numbered_max = 0;
  std::vector<events::RunEvent> numbered{};
  std::vector<events::RunEvent> others{};  ///< the newest of each kind

  bool is_full() const { return numbered.size() >= numbered_max; }
  void replace(events::RunEvent event) {
    std::erase_if(others, [&](const events::RunEvent& other) {
      return other.what.index() == event.what.index();
    });
    others.push_back(std::move(event));
  }
  std::vector<events::RunEvent> finish() {
    std::ranges::move(others, std::back_inserter(numbered));
    return std::move(numbered);
  }
};

ToldEvents::ToldEvents(std::string folder, std::uint64_t number)
    : folder_(std::move(folder)), number_(number) {
  CHECK_GE(number, 1U);
}

std::vector<events::RunEvent> ToldEvents::next(std::size_t numbered_max) {
  CHECK_GE(numbered_max, 1U);
  Answer answer{.numbered_max = numbered_max};
  read_log(answer);
  return answer.finish();
}

std::vector<events::RunEvent> ToldEvents::rest(std::size_t numbered_max) {
  CHECK_GE(numbered_max, 1U);
  Answer answer{.numbered_max = numbered_max};
  read_log(answer);
  fill_from_store(k_no_end, answer);
  return answer.finish();
}

void ToldEvents::read_log(Answer& answer) {
  const std::string path = events::event_log_path(folder_);
  for (int look = 0; look < k_looks_max; ++look) {
    const LogFile now(path);
    if (now.has(place_.device, place_.inode, place_.offset)) {
      take(now, answer);
      return;
    }
    // The log's file was replaced since the last call. The replaced file may be the old log now.
    const LogFile old(events::old_event_log_path(folder_));
    if (LogFile again(path); again.is_there() != now.is_there() ||
                             (now.is_there() && !again.is(now.device(), now.inode())))
      continue;
    if (old.is_there()) {
      const bool is_known = old.has(place_.device, place_.inode, place_.offset);
      place_ = {
          .device = old.device(), .inode = old.inode(), .offset = is_known ? place_.offset : 0};
      if (!take(old, answer)) return;
    }
    if (!now.is_there()) return;
    place_ = {.device = now.device(), .inode = now.inode(), .offset = 0};
    take(now, answer);
    return;
  }
}

/// Reads the file from place_. Returns false if the answer has no room for the rest.
bool ToldEvents::take(const LogFile& file, Answer& answer) {
  while (true) {
    const std::uint64_t begin = place_.offset;
    const std::string text = file.piece_from(begin);
    if (!take_lines(text, answer)) return false;
    // If a piece has no whole line, its line is still being written.
    if (text.size() < k_told_piece_bytes || place_.offset == begin) return true;
  }
}

/// Reads whole lines, and moves the place behind them. False as in take().
bool ToldEvents::take_lines(const std::string& text, Answer& answer) {
  for (std::size_t begin = 0;;) {
    const std::size_t end = text.find('\n', begin);
    if (end == std::string::npos) return true;
    auto event = events::run_event_of(std::string_view(text).substr(begin, end - begin));
    if (event && event->number == 0) {
      answer.replace(*std::move(event));
    } else if (event && event->number >= number_) {
      if (event->number > number_) fill_from_store(event->number, answer);
      if (answer.is_full()) return false;
      if (event->number != number_) {
        refuse_damaged(RunStore::database_path(folder_),
                       fmt::format("event {} is missing", number_));
      }
      answer.numbered.push_back(*std::move(event));
      ++number_;
    }
    place_.offset += end + 1 - begin;
    begin = end + 1;
  }
}

/// Adds events whose numbers are below `end`, as far as the answer has room.
void ToldEvents::fill_from_store(std::uint64_t end, Answer& answer) {
  if (answer.is_full()) return;
  const std::shared_ptr<SharedDatabase> database = open_store(folder_);
  if (!database) return;
  const std::uint64_t salt = salt_of(run_value(*database, "identity"));
  const SharedDatabase::Turn turn = database->turn();
  Statement select = turn->prepare(
      "SELECT number, line, checksum FROM event WHERE number>=?1 AND number<?2 ORDER BY number "
      "LIMIT ?3");
  const auto bound = [](std::uint64_t value) {
    return static_cast<std::int64_t>(
        std::min<std::uint64_t>(value, std::numeric_limits<std::int64_t>::max()));
  };
  select.bind(1, bound(number_)).bind(2, bound(end));
  select.bind(3, bound(answer.numbered_max - answer.numbered.size()));
  while (select.step()) {
    const auto number = static_cast<std::uint64_t>(select.integer(0));
    const std::string line = select.text(1);
    auto event = events::run_event_of(line);
    const bool is_sound = event && event->number == number && number == number_ &&
                          checksum_of_event(salt, number, line) == select.integer(2);
    if (!is_sound) refuse_damaged(database->path(), fmt::format("event {}", number_));
    answer.numbered.push_back(*std::move(event));
    ++number_;
  }
}

std::vector<events::RunEvent> events_told(const std::string& folder, std::uint64_t number,
                                          std::size_t numbered_max) {
  return ToldEvents(folder, number).rest(numbered_max);
}

}  // namespace sleight::store
