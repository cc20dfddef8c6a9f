#include "clients/pictures/ffmpeg.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <string_view>

#include "clients/plot/text.h"
#include "common/base/check.h"
#include "common/base/error.h"

namespace sleight::pictures {
namespace {

/// Maximum lines of ffmpeg's messages that are shown.
constexpr std::size_t k_lines_shown = 6;
constexpr long k_tail_bytes = 4096;
/// Fixed number of threads, so that the same frames give the same file on any machine.
constexpr int k_threads = 4;

/// Returns the last lines of a file in printable form.
std::vector<std::string> last_lines(std::FILE* file) {
  std::fseek(file, 0, SEEK_END);
  const long size = std::ftell(file);
  std::fseek(file, std::max(0L, size - k_tail_bytes), SEEK_SET);
  std::string text(static_cast<std::size_t>(k_tail_bytes), '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file));
  std::vector<std::string> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find_first_of("\r\n", begin), text.size());
    if (end > begin) lines.push_back(plot::printable(text.substr(begin, end - begin)));
    begin = end + 1;
  }
  if (lines.size() > k_lines_shown)
    lines.erase(lines.begin(), lines.end() - static_cast<std::ptrdiff_t>(k_lines_shown));
  return lines;
}

[[noreturn]] void fail_to_start(int reason) {
  if (reason == ENOENT) {
    throw base::Error(
        "ffmpeg, which encodes videos, is not installed: install it (Debian: apt-get install "
        "ffmpeg), or write the frames as PNG files");
  }
  throw base::Error(fmt::format("ffmpeg can't be started: {}", std::strerror(reason)));
}

}  // namespace

std::vector<std::string> ffmpeg_command(const FfmpegOptions& options) {
  return {"ffmpeg", "-hide_banner", "-loglevel", "error", "-nostats",
          // Input.
          "-f", "rawvideo", "-pixel_format", "bgr0", "-video_size",
          fmt::format("{}x{}", options.columns, options.rows), "-framerate",
          fmt::format("{}", options.fps), "-i", "pipe:0",
          // Encoding that every player supports. Slower presets of x264 don't help with flat
          // colours: HI's film takes 1.5 times as long and isn't smaller.
          "-an", "-c:v", "libx264", "-preset", "veryfast", "-pix_fmt", "yuv420p", "-threads",
          fmt::format("{}", k_threads), "-movflags", "+faststart", "-fflags", "+bitexact",
          "-flags:v", "+bitexact",
          // "file:" protects names that look like another protocol or an option.
          "-f", "mp4", "-y", "file:" + options.output};
}

bool is_whole_mp4(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) return false;
  const auto bytes = static_cast<std::uint64_t>(file.tellg());
  bool has_film = false;
  bool has_index = false;
  std::uint64_t at = 0;
  const auto number = [&](std::size_t width) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < width; ++i)
      value = value << 8U | static_cast<unsigned char>(file.get());
    return value;
  };
  while (at < bytes) {
    constexpr std::uint64_t k_head_bytes = 8;
    file.seekg(static_cast<std::streamoff>(at));
    std::uint64_t size = number(4);
    std::array<char, 4> kind{};
    file.read(kind.data(), kind.size());
    // In an MP4 box, a size of 1 means that a 64-bit size follows the kind.
    if (size == 1) size = number(8);
    if (!file || size < k_head_bytes || size > bytes - at) return false;
    has_film = has_film || std::string_view(kind.data(), kind.size()) == "mdat";
    has_index = has_index || std::string_view(kind.data(), kind.size()) == "moov";
    at += size;
  }
  return has_film && has_index;
}

Ffmpeg::Ffmpeg(const FfmpegOptions& options)
    : frame_bytes_(std::size_t{4} * options.columns * options.rows),
      messages_(std::tmpfile()),
      output_(options.output) {
  CHECK_EQ(options.columns % 2 + options.rows % 2, 0U);
  if (!messages_)
    throw base::Error(fmt::format("can't create a temporary file: {}", std::strerror(errno)));
  // Use a socket: if its other end closes, no signal is sent, unlike for a pipe.
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
    throw base::Error(fmt::format("can't create a socket: {}", std::strerror(errno)));
  input_ = ends[0];

  std::vector<std::string> command = ffmpeg_command(options);
  std::vector<char*> arguments;
  for (std::string& word : command)
    arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions{};
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, ends[1], STDIN_FILENO);
  ::posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  ::posix_spawn_file_actions_adddup2(&actions, ::fileno(messages_.get()), STDERR_FILENO);
  const int reason =
      ::posix_spawnp(&id_, arguments[0], &actions, nullptr, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  if (reason == 0) return;
  id_ = -1;
  ::close(input_);
  fail_to_start(reason);
}

Ffmpeg::~Ffmpeg() {
  if (input_ >= 0) ::close(input_);
  if (id_ < 0) return;
  ::kill(id_, SIGKILL);
  wait();
}

void Ffmpeg::send(base::BytesView frame) {
  CHECK_EQ(frame.size(), frame_bytes_);
  CHECK_GE(input_, 0);
  while (!frame.empty()) {
    const ssize_t put = ::send(input_, frame.data(), frame.size(), MSG_NOSIGNAL);
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) fail();
    frame = frame.subspan(static_cast<std::size_t>(put));
  }
}

void Ffmpeg::finish() {
  ::close(input_);
  input_ = -1;
  const int status = wait();
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || !is_whole_mp4(output_)) fail();
}

int Ffmpeg::wait() {
  int status = 0;
  while (::waitpid(id_, &status, 0) < 0 && errno == EINTR) {
  }
  id_ = -1;
  return status;
}

void Ffmpeg::fail() {
  // Without input, ffmpeg ends by itself after printing the reason.
  if (input_ >= 0) ::close(input_);
  input_ = -1;
  if (id_ >= 0) wait();
  const std::vector<std::string> lines = last_lines(messages_.get());
  throw base::Error(
      fmt::format("ffmpeg could not encode the video{}{}",
                  lines.empty() ? " and printed no reason (is the disk full?)" : ":\n  ",
                  fmt::join(lines, "\n  ")));
}

}  // namespace sleight::pictures
