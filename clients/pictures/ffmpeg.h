// The program `ffmpeg` as an encoder: it gets frames as raw pixels and makes an MP4 of H.264.
//
// It runs as a process of its own, started without a shell; frames go to its standard input. Its
// messages are kept, and shown where it fails. Not thread-safe.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "common/base/bytes.h"

namespace sleight::pictures {

struct FfmpegOptions {
  std::string output;         ///< a file, which is replaced, of whatever name
  std::uint32_t columns = 0;  ///< even
  std::uint32_t rows = 0;     ///< even
  double fps = 24;
};

/// The command, its name first.
std::vector<std::string> ffmpeg_command(const FfmpegOptions& options);

/// Whether a file is an MP4 from its first to its last byte: its boxes fill it, and the film and
/// its index are among them (ISO/IEC 14496-12, 4.2). On a full disk ffmpeg may end well all the
/// same.
bool is_whole_mp4(const std::string& path);

class Ffmpeg {
 public:
  /// Throws base::Error(environment) that says what to install where there is no `ffmpeg` on PATH.
  explicit Ffmpeg(const FfmpegOptions& options);
  Ffmpeg(const Ffmpeg&) = delete;
  Ffmpeg& operator=(const Ffmpeg&) = delete;
  /// Ends it where it still runs.
  ~Ffmpeg();

  /// A frame: rows from above, each pixel as blue, green, red and an unused byte. Throws
  /// base::Error(environment) with ffmpeg's last words when it has ended.
  /// REQUIRES: 4 * columns * rows bytes; finish was not called.
  void send(base::BytesView frame);
  /// Waits until the file is whole; likewise.
  void finish();

 private:
  [[noreturn]] void fail();
  int wait();

  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::size_t frame_bytes_;
  std::unique_ptr<std::FILE, CloseFile> messages_;
  std::string output_;
  int input_ = -1;  ///< our end
  pid_t id_ = -1;
};

}  // namespace sleight::pictures
