// Writes failed simulations as files in `<output>.run/failures`, for `sleight replay`.
//
// A file's name is the simulation's place in the run. So if a failure arrives twice, it is written
// once. Not thread-safe.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/base/file_system.h"
#include "common/plan/unit.h"

namespace sleight::coordinator {

/// Maximum failure files of a run. Later failures are only counted.
inline constexpr std::size_t k_failure_files_max = 10;

class FailureFiles {
 public:
  /// Borrows the file system. REQUIRES: `run_folder` exists.
  FailureFiles(const std::string& run_folder, std::string request_text, base::FileSystem& files);

  /// Writes a file from which `sleight replay` can repeat the failure, and returns the file's path.
  /// None: the run has k_failure_files_max files already. Throws base::Error if the disk fails.
  std::optional<std::string> keep(const plan::ReplicaKey& replica,
                                  const plan::FailedSimulation& failed);

  /// Returns the path of a scan's first failure of this kind, in any session. Empty: there is no
  /// file.
  std::string path_of(const plan::ReplicaKey& replica, base::ScanIndex scan,
                      plan::FailureKind kind) const;

  /// Deletes all failure files of an earlier run, for --fresh.
  static void remove_all(const std::string& run_folder, base::FileSystem& files);

 private:
  std::string folder_;
  std::string request_text_;
  base::FileSystem& files_;
  struct Kept {
    plan::ReplicaKey replica;
    base::ScanIndex scan;
    plan::FailureKind kind{};
    std::string path;
  };
  static void describe(Kept& kept);

  std::vector<Kept> kept_;
  // The last failure. It serves to number a scan's failures.
  plan::ReplicaKey last_replica_;
  base::ScanIndex last_scan_;
  std::size_t nth_ = 0;
  bool has_last_ = false;
};

}  // namespace sleight::coordinator
