#include "common/archive/hdf5/writer.h"

#include <fmt/format.h>
#include <unistd.h>

#include "common/archive/digest/digest.h"
#include "common/archive/hdf5/file_sink.h"
#include "common/archive/hdf5/handle.h"
#include "common/archive/hdf5/output_file.h"

namespace sleight::archive::hdf5 {
namespace {

/// Removes the temporary file, unless it was renamed to the archive's path.
class Temporary {
 public:
  Temporary(base::FileSystem& file_system, std::string path)
      : file_system_(file_system), path_(std::move(path)) {}
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  ~Temporary() {
    if (placed_) return;
    try {
      file_system_.remove(path_);
    } catch (const base::Error&) {
      // Ignore failures here, because an earlier failure is being reported.
    }
  }

  const std::string& path() const { return path_; }
  void set_placed() { placed_ = true; }

 private:
  base::FileSystem& file_system_;
  std::string path_;
  bool placed_ = false;
};

std::string write_whole(const std::string& path, base::FileSystem& file_system,
                        const std::function<void(Sink&)>& fill) {
  const Api api(path, base::ExitCode::environment);
  OutputFile output(path, file_system);
  FileSink sink(api, output);
  std::string digest = write_digested(sink, fill);
  output.close();
  return digest;
}

}  // namespace

std::string write_file(const std::string& path, base::FileSystem& file_system,
                       const std::function<void(Sink&)>& fill) {
  Temporary temporary(file_system, fmt::format("{}.tmp.{}", path, ::getpid()));
  const std::string digest = write_whole(temporary.path(), file_system, fill);
  file_system.sync_file(temporary.path());
  file_system.rename(temporary.path(), path);
  temporary.set_placed();
  file_system.sync_directory_of(path);
  return digest;
}

}  // namespace sleight::archive::hdf5
