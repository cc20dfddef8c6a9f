// Runs the program `ffmpeg` as an encoder: raw pixels of frames become an H.264 MP4.
//
// ffmpeg runs as a separate process without a shell, and reads frames from its standard input.
// ffmpeg's messages are stored, and shown if it fails. Not thread-safe.
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
  std::string output;         ///< file of any name, replaced if it exists
  std::uint32_t columns = 0;  ///< even
  std::uint32_t rows = 0;     ///< even
  double fps = 24;
};

/// Returns the command line, with the program's name first.
std::vector<std::string> ffmpeg_command(const FfmpegOptions& options);

/// Whether a file is a complete MP4: its boxes fill the file and include the film and its index
/// (ISO/IEC 14496-12, 4.2). The check is needed because ffmpeg may report success on a full disk.
bool is_whole_mp4(const std::string& path);

class Ffmpeg {
 public:
  /// Throws base::Error(environment) with installation advice if there is no `ffmpeg` on PATH.
  explicit Ffmpeg(const FfmpegOptions& options);
  Ffmpeg(const Ffmpeg&) = delete;
  Ffmpeg& operator=(const Ffmpeg&) = delete;
  /// Kills the process if it still runs.
  ~Ffmpeg();

  /// Sends a frame: rows from the top, each pixel as blue, green, red and an unused byte. Throws
  /// base::Error(environment) with ffmpeg's last messages if it has ended.
  /// REQUIRES: 4 * columns * rows bytes; finish() was not called.
  void send(base::BytesView frame);
  /// Waits until the file is complete. Throws like send().
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
