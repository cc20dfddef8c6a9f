#include "service/daemon/logs.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <fstream>

#include "common/base/error.h"
#include "service/keeper/command.h"

namespace sleight::daemon {
namespace {

struct OnDisk {
  std::uint64_t inode = 0;  ///< 0: no file
  std::uint64_t size = 0;
};

OnDisk look(const std::string& path) {
  struct stat file {};
  if (::stat(path.c_str(), &file) != 0) return {};
  return {.inode = file.st_ino, .size = static_cast<std::uint64_t>(file.st_size)};
}

std::string piece_of(const std::string& path, std::uint64_t offset, std::uint64_t count) {
  if (count == 0) return {};
  std::ifstream file(path, std::ios::binary);
  std::string text(count, '\0');
  file.seekg(static_cast<std::streamoff>(offset));
  file.read(text.data(), static_cast<std::streamsize>(count));
  if (file.bad()) throw base::Error(fmt::format("{}: can't read the log", path));
  text.resize(static_cast<std::size_t>(file.gcount()));
  return text;
}

std::string tail_of(const std::string& text, std::uint32_t lines) {
  std::size_t begin = text.size();
  for (std::uint32_t line = 0; line <= lines && begin > 0; ++line) {
    const std::size_t end = begin - 1;
    const std::size_t newline = end == 0 ? std::string::npos : text.rfind('\n', end - 1);
    if (line == lines) break;
    begin = newline == std::string::npos ? 0 : newline + 1;
  }
  return text.substr(begin);
}

}  // namespace

rpc::LogPiece Logs::read(const std::string& folder, const rpc::LogAsk& ask) {
  const std::string path = folder + "/" + keeper::k_log_name;
  const std::string old_path = folder + "/" + keeper::k_old_log_name;
  const OnDisk old = look(old_path);
  const OnDisk now = look(path);
  Known& known = known_[folder];
  // `log` has become `log.old`. The bytes of the previous `log.old` are lost, but their numbers
  // aren't used again.
  if (known.inode != 0 && old.inode == known.inode) known.base += known.old_size;
  known = {.old_inode = old.inode,
           .inode = now.inode,
           .base = known.base,
           .old_size = old.size,
           .size = now.size};

  const std::uint64_t bytes_max = std::min<std::uint64_t>(ask.bytes_max, rpc::k_log_bytes_max);
  const std::uint64_t end = known.base + old.size + now.size;
  std::uint64_t first = ask.from ? std::clamp(*ask.from, known.base, end)
                                 : end - std::min(bytes_max, end - known.base);
  rpc::LogPiece piece{.first = first, .end = end};
  const std::uint64_t into = first - known.base;
  const std::uint64_t count = std::min(bytes_max, end - first);
  if (into < old.size) piece.text = piece_of(old_path, into, std::min(count, old.size - into));
  if (piece.text.size() < count) {
    const std::uint64_t at = into + piece.text.size() - old.size;
    piece.text += piece_of(path, at, count - piece.text.size());
  }
  if (!ask.from) {
    std::string tail = tail_of(piece.text, ask.lines);
    piece.first += piece.text.size() - tail.size();
    piece.text = std::move(tail);
  }
  return piece;
}

}  // namespace sleight::daemon
