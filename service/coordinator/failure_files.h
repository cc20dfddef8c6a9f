// Keeps simulations that failed as files beside the run, so that `sleight replay` repeats them.
//
// They lie in `<output>.run/failures`. A file is named by where in the run its simulation was, so a
// result that is lost and computed again is written once. Not thread-safe.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/base/file_system.h"
#include "common/plan/unit.h"

namespace sleight::coordinator {

/// Files of a run; later failures are counted alone.
inline constexpr std::size_t k_failure_files_max = 10;

class FailureFiles {
 public:
  /// Borrows the file system. `run_folder` exists; nothing is written before the first failure.
  FailureFiles(const std::string& run_folder, std::string request_text, base::FileSystem& files);

  /// The file that repeats a failure; none if there are k_failure_files_max already. Throws
  /// base::Error when the disk fails.
  std::optional<std::string> keep(const plan::ReplicaKey& replica,
                                  const plan::FailedSimulation& failed);

  /// The file of the first failure of a kind in a scan, by this session or an earlier one; empty if
  /// there is none.
  std::string path_of(const plan::ReplicaKey& replica, base::ScanIndex scan,
                      plan::FailureKind kind) const;

  /// Removes those of an earlier run that is given up.
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
  // The failure that came last, to number those of one scan.
  plan::ReplicaKey last_replica_;
  base::ScanIndex last_scan_;
  std::size_t nth_ = 0;
  bool has_last_ = false;
};

}  // namespace sleight::coordinator
