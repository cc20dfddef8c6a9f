// The files that an export leaves: how they are called, and that nothing of anybody else's is
// replaced.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

namespace sleight::cli {

/// A file of the output, or a folder of frames.
struct WrittenFile {
  std::string path;
  std::vector<std::string> ids;
  std::uint64_t bytes = 0;
};

/// "3f2a9c01-c0.250": the run's first letters and digits, whatever an archive calls it, and the
/// animation's id.
std::string export_name(const std::string& run_id, const std::string& id);

/// Makes it and what it lies in. Throws base::Error naming it.
void make_export_folder(const std::string& path);

/// Throws base::Error(conflict) if a file is there that sleight did not make, as far as can be
/// told; not where `force`.
void refuse_others_file(const std::string& path, bool force);

/// Tells stderr how far an export is, now and then, where it takes long: a line a second at most.
/// Throws what terminal::Interruption::check does.
class ExportProgress {
 public:
  explicit ExportProgress(std::size_t all) : all_(all) {}
  /// Animations that are done, and of the next one frames of so many.
  void done(std::size_t count, std::size_t frames = 0, std::size_t of = 0);

 private:
  std::size_t all_;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point told_ = began_;
};

}  // namespace sleight::cli
