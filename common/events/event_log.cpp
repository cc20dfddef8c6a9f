#include "common/events/event_log.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <utility>

#include "common/logging/log.h"

namespace sleight::events {

std::string event_log_path(const std::string& folder) {
  return folder + "/events.log";
}

std::string old_event_log_path(const std::string& folder) {
  return folder + "/events.old.log";
}

namespace {

class Reader {
 public:
  explicit Reader(const std::string& path)
      : descriptor_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {}
  ~Reader() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  bool is_file_at(const std::string& path) const {
    struct stat mine {};
    struct stat now {};
    const bool is_there = ::stat(path.c_str(), &now) == 0;
    if (descriptor_ < 0) return !is_there;
    return ::fstat(descriptor_, &mine) == 0 && is_there && mine.st_ino == now.st_ino &&
           mine.st_dev == now.st_dev;
  }
  std::string content() const {
    std::string text;
    std::array<char, 1U << 16U> piece{};
    for (ssize_t size = 0; descriptor_ >= 0;) {
      size = ::read(descriptor_, piece.data(), piece.size());
      if (size < 0 && errno == EINTR) continue;
      if (size <= 0) break;
      text.append(piece.data(), static_cast<std::size_t>(size));
    }
    return text;
  }

 private:
  int descriptor_;
};

}  // namespace

EventLog::EventLog(std::string folder, std::uint64_t bytes_max)
    : folder_(std::move(folder)),
      bytes_max_(bytes_max),
      clock_(own_clock_),
      looked_s_(clock_.now_s()) {
  open();
}

EventLog::EventLog(std::string folder, std::uint64_t bytes_max, const base::Clock& clock)
    : folder_(std::move(folder)), bytes_max_(bytes_max), clock_(clock), looked_s_(clock.now_s()) {
  open();
}

EventLog::~EventLog() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void EventLog::open() {
  const std::string path = event_log_path(folder_);
  descriptor_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (descriptor_ < 0) {
    give_up(std::strerror(errno));
    return;
  }
  // A killed process may have left an incomplete line.
  const std::string text = Reader(path).content();
  const std::size_t last = text.rfind('\n');
  bytes_ = last == std::string::npos ? 0 : last + 1;
  if (bytes_ != text.size() && ::ftruncate(descriptor_, static_cast<off_t>(bytes_)) != 0)
    give_up(std::strerror(errno));
}

void EventLog::look_now_and_then() {
  const double now_s = clock_.now_s();
  if (now_s - looked_s_ < k_event_log_look_every_s) return;
  looked_s_ = now_s;
  struct stat mine {};
  struct stat there {};
  if (descriptor_ >= 0) {
    const bool is_there = ::fstat(descriptor_, &mine) == 0 &&
                          ::stat(event_log_path(folder_).c_str(), &there) == 0 &&
                          mine.st_ino == there.st_ino && mine.st_dev == there.st_dev;
    if (is_there) return;
    ::close(descriptor_);
  }
  open();
}

void EventLog::append(const RunEvent& event) {
  look_now_and_then();
  if (descriptor_ < 0) return;
  const std::string line = to_line(event);
  if (bytes_ > 0 && bytes_ + line.size() > bytes_max_ / 2) turn_over();
  if (descriptor_ < 0) return;
  // Remove an incomplete line, because otherwise the next line would be appended to it.
  const ssize_t written = ::write(descriptor_, line.data(), line.size());
  if (written != static_cast<ssize_t>(line.size())) {
    const std::string reason = written < 0 ? std::strerror(errno) : "no space for a whole line";
    if (::ftruncate(descriptor_, static_cast<off_t>(bytes_)) != 0) {
      // Readers skip the incomplete line.
    }
    give_up(reason);
    return;
  }
  bytes_ += line.size();
}

void EventLog::turn_over() {
  ::close(descriptor_);
  descriptor_ = -1;
  if (::rename(event_log_path(folder_).c_str(), old_event_log_path(folder_).c_str()) != 0) {
    give_up(std::strerror(errno));
    return;
  }
  open();
}

void EventLog::give_up(const std::string& reason) {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
  if (std::exchange(has_complained_, true)) return;
  logging::warn(
      fmt::format("{}: can't write: {}; the run continues", event_log_path(folder_), reason));
}

std::vector<RunEvent> read_event_log(const std::string& folder) {
  // The writer may rotate the files between the two opens. So check that the two opened files
  // existed at the same time.
  std::string text;
  for (int tries = 0; tries < 100; ++tries) {
    const Reader now(event_log_path(folder));
    const Reader old(old_event_log_path(folder));
    if (!now.is_file_at(event_log_path(folder))) continue;
    text = old.content() + now.content();
    break;
  }
  std::vector<RunEvent> events;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    if (end == std::string::npos) break;
    if (auto event = run_event_of(std::string_view(text).substr(begin, end - begin)))
      events.push_back(*std::move(event));
    begin = end + 1;
  }
  return events;
}

}  // namespace sleight::events
