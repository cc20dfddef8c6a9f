#include "service/keeper/bounded_log.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <utility>

#include "service/keeper/command.h"

namespace sleight::keeper {

BoundedLog::BoundedLog(std::string folder, std::uint64_t bytes_max)
    : folder_(std::move(folder)), bytes_max_(bytes_max) {
  open();
}

BoundedLog::~BoundedLog() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void BoundedLog::open() {
  const std::string path = folder_ + "/" + k_log_name;
  descriptor_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0600);
  const off_t size = descriptor_ < 0 ? 0 : ::lseek(descriptor_, 0, SEEK_END);
  bytes_ = size > 0 ? static_cast<std::uint64_t>(size) : 0;
  // An earlier keeper may have been killed in the middle of a line.
  char last = '\n';
  if (bytes_ > 0 && ::pread(descriptor_, &last, 1, size - 1) == 1) at_line_begin_ = last == '\n';
}

void BoundedLog::append(std::string_view bytes) {
  if (lost_ > 0 && !bytes.empty()) {
    const std::string words =
        fmt::format("{}{} bytes of output were lost because the disk could not be written\n",
                    k_log_mark, lost_);
    if (write(words) == words.size()) lost_ = 0;
  }
  while (!bytes.empty()) {
    if (bytes_ >= bytes_max_ / 2) turn_over();
    // If the file could be neither renamed nor removed, it is still full.
    const std::uint64_t room = bytes_max_ / 2 - std::min(bytes_max_ / 2, bytes_);
    const std::string_view piece = bytes.substr(0, room);
    if (piece.empty()) {
      lost_ += bytes.size();
      return;
    }
    const std::size_t written = write(piece);
    if (written < piece.size()) {
      lost_ += bytes.size() - written;
      return;
    }
    bytes.remove_prefix(written);
  }
}

void BoundedLog::mark(std::string_view words) {
  std::string line = at_line_begin_ ? "" : "\n";
  line += k_log_mark;
  // Put the message on one line.
  for (const char c : words)
    line += c == '\n' ? ' ' : c;
  append(line + "\n");
}

void BoundedLog::turn_over() {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
  const std::string path = folder_ + "/" + k_log_name;
  const std::string old = folder_ + "/" + k_old_log_name;
  // If renaming fails, delete the log to stay within the bound.
  if (std::rename(path.c_str(), old.c_str()) != 0) ::unlink(path.c_str());
  open();
}

std::size_t BoundedLog::write(std::string_view bytes) {
  if (descriptor_ < 0) open();
  std::size_t written = 0;
  while (descriptor_ >= 0 && written < bytes.size()) {
    const ssize_t count = ::write(descriptor_, bytes.data() + written, bytes.size() - written);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    written += static_cast<std::size_t>(count);
  }
  bytes_ += written;
  if (written > 0) at_line_begin_ = bytes[written - 1] == '\n';
  return written;
}

void LastLines::append(std::string_view bytes) {
  while (!bytes.empty()) {
    const std::size_t end = bytes.find('\n');
    const std::string_view piece = bytes.substr(0, end);
    open_ += piece.substr(0, k_line_bytes_max - std::min(k_line_bytes_max, open_.size()));
    if (end == std::string_view::npos) return;
    lines_.push_back(std::exchange(open_, {}));
    if (lines_.size() > lines_max_) lines_.pop_front();
    bytes.remove_prefix(end + 1);
  }
}

std::vector<std::string> LastLines::lines() const {
  std::vector<std::string> lines(lines_.begin(), lines_.end());
  if (!open_.empty()) lines.push_back(open_);
  if (lines.size() > lines_max_) lines.erase(lines.begin());
  return lines;
}

}  // namespace sleight::keeper
