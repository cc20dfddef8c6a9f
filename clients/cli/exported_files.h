// Names an export's files, and protects files that sleight didn't make.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace sleight::cli {

/// An output file, or a folder of frames.
struct WrittenFile {
  std::string path;
  std::vector<std::string> ids;
  std::uint64_t bytes = 0;
};

/// Returns, for example, "3f2a9c01-c0.250": the first letters and digits of the run id, which is
/// untrusted, then the animation's id.
std::string export_name(const std::string& run_id, const std::string& id);

/// Creates the folder and its parents. Throws base::Error with the path.
void make_export_folder(const std::string& path);

/// If sleight didn't make an existing file and `force` isn't set, throws base::Error(conflict).
void refuse_others_file(const std::string& path, bool force);

/// Prints a slow export's progress to stderr, at most once a second. Throws as
/// terminal::Interruption::check does.
class ExportProgress {
 public:
  explicit ExportProgress(std::size_t all) : all_(all) {}
  /// `count`: finished animations. `frames`: finished frames of the next animation. `of`: all its
  /// frames.
  void done(std::size_t count, std::size_t frames = 0, std::size_t of = 0);

 private:
  std::size_t all_;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point told_ = began_;
};

}  // namespace sleight::cli
